// The viewer: a page and its parts, one line each.
import { byId, element } from "./page/elements.js";
import { embedded } from "./page/embedded.js";
import { connectGlossary } from "./page/glossary.js";
import { connectKeys } from "./page/keys.js";
import { Page } from "./page/page.js";
import { connectParts } from "./page/parts.js";
import { openPage } from "./page/start.js";
import { Uploads } from "./page/uploads.js";
import { ColourList } from "./panels/colour_list.js";
import { ComparisonPanel } from "./panels/comparison_panel.js";
import { connectDisplay } from "./panels/display.js";
import { connectFacts } from "./panels/facts.js";
import { GamutList } from "./panels/gamut_list.js";
import { connectLevel } from "./panels/level.js";
import { Marks } from "./panels/marks.js";
import { MatchTable } from "./panels/match_table.js";
import { PicturePanel } from "./panels/picture_panel.js";
import { connectPointer } from "./panels/pointer.js";
import { Readout } from "./panels/readout.js";
import { SlicePanel } from "./panels/slice_panel.js";
import { connectSaving } from "./panels/take_away.js";

declare global {
  interface Window {
    gamutViewer?: Page;
  }
}

function start(): Page {
  const page = new Page();
  connectDisplay(page);
  connectLevel(page);
  connectFacts(page);
  const readout = new Readout(page);
  connectPointer(page, readout);
  connectKeys(page);
  connectGlossary();
  connectParts();
  new GamutList(page);
  const { figure } = new SlicePanel(page, readout);
  const colours = new ColourList(page);
  new MatchTable(page, colours);
  connectSaving(page, { figure, comparison: new ComparisonPanel(page) });
  if (embedded === null) {
    new Uploads(page, { colours, picture: new PicturePanel(page) });
    new Marks(page);
  } else byId("title").textContent = embedded.gamuts.map(({ gamut }) => gamut.name).join(" and ");
  void openPage(page);
  return page;
}

try {
  window.gamutViewer = start();
} catch (error) {
  document.getElementById("static-note")?.removeAttribute("hidden");
  const box = byId("problem");
  box.hidden = false;
  box.append(element("strong", "This browser cannot show the view"), element("p", String(error)));
}
