"""Alerts and dashboard use existing metrics with their labels."""

import asyncio
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from prometheus_client.parser import text_string_to_metric_families

from service.application import create_app
from service.problems.kinds import KINDS
from service.settings import Settings
from service.telemetry.metrics import exposition

FOLDER = Path(__file__).parents[2] / "deploy" / "observability"
ALERTS = FOLDER / "alerts.yaml"
DASHBOARD = json.loads((FOLDER / "dashboard.json").read_text())

OF_PROMETHEUS = {"up": {"job", "instance"}}
"""Metrics that Prometheus itself adds."""

OF_TARGETS = {"job", "instance"}
"""Labels that Prometheus adds to all metrics."""


@pytest.fixture(scope="module")
def labels(tmp_path_factory):
    """Labels of all metrics of a service, by the name of the samples."""
    service = create_app(
        Settings(store=str(tmp_path_factory.mktemp("store")), store_bytes=10**9)
    ).state.service
    service.store.open()
    service.metrics.requests.count_answer("GET", "/", 200, 0.1)
    service.metrics.builds.count_build("succeeded", {"boundary": 0.5, "total": 1.0})
    service.metrics.queries.count("contains", 1, 0.1)
    asyncio.run(service.readiness.report())
    body, _ = exposition(service.metrics.registry, "")
    service.store.close()
    found = dict(OF_PROMETHEUS)
    for family in text_string_to_metric_families(body.decode()):
        for sample in family.samples:
            found.setdefault(sample.name, set()).update({*sample.labels, *OF_TARGETS})
    return found


RULES = [rule for group in yaml.safe_load(ALERTS.read_text())["groups"] for rule in group["rules"]]
PANELS = [panel for panel in DASHBOARD["panels"] if panel["type"] != "row"]
TARGETS = [target["expr"] for panel in PANELS for target in panel["targets"]]


@pytest.mark.parametrize("expression", [*(rule["expr"] for rule in RULES), *TARGETS])
def test_every_figure_that_is_asked_for_is_told_with_these_labels(labels, expression):
    bare = re.sub(r'"(?:[^"\\]|\\.)*"', '""', expression)
    selected = re.findall(r"\b(gamut_\w+|process_\w+|up)\b(?:\{([^}]*)\})?", bare)
    assert selected
    names = set()
    for name, matchers in selected:
        assert name in labels, name
        names |= labels[name]
        assert set(re.findall(r"(\w+)\s*(?:=~|!~|!=|=)", matchers)) <= labels[name]
    for grouped in re.findall(r"\bby \(([^)]*)\)", bare):
        assert set(re.split(r",\s*", grouped)) <= names


def test_every_figure_of_the_service_s_own_is_on_the_dashboard(labels):
    shown = set(re.findall(r"\bgamut_\w+", " ".join(TARGETS)))
    told = {
        re.sub(r"_(?:bucket|sum|count)\Z", "", name) for name in labels if name.startswith("gamut_")
    }
    bases = {re.sub(r"_(?:bucket|sum|count)\Z", "", name) for name in shown}
    assert told - bases == {"gamut_build_info", "gamut_worker_processes"}


def test_alerts_say_what_happened_and_what_to_do():
    names = [rule["alert"] for rule in RULES]
    assert len(set(names)) == len(names)
    for rule in RULES:
        assert rule["labels"]["severity"] in {"critical", "warning"}
        assert rule["annotations"]["summary"]
        assert rule["annotations"]["description"]


def test_outcomes_that_alerts_name_are_problems():
    (named,) = re.findall(r'outcome=~"([^"]+)"', ALERTS.read_text())
    assert set(named.split("|")) <= set(KINDS)


def test_the_dashboard_is_one_that_grafana_draws():
    assert DASHBOARD["uid"] == "gamut"
    variables = {variable["name"] for variable in DASHBOARD["templating"]["list"]}
    text = json.dumps(DASHBOARD)
    assert set(re.findall(r"\$\{?([a-z]\w*)", text)) <= variables
    ids = [panel["id"] for panel in DASHBOARD["panels"]]
    assert len(set(ids)) == len(ids)
    for panel in PANELS:
        assert panel["title"]
        assert panel["datasource"]["uid"] == "${datasource}"
        references = [target["refId"] for target in panel["targets"]]
        assert len(set(references)) == len(references)


def test_prometheus_own_tool_accepts_all_expressions(tmp_path):
    if shutil.which("promtool") is None:
        pytest.skip("promtool is missing: Debian's package prometheus has it")
    recorded = [
        # Grafana replaces its variables before the query
        {"record": f"panel:{number}", "expr": re.sub(r"\$__rate_interval", "5m", expression)}
        for number, expression in enumerate(TARGETS)
    ]
    path = tmp_path / "panels.yaml"
    path.write_text(yaml.safe_dump({"groups": [{"name": "panels", "rules": recorded}]}))
    subprocess.run(
        ["promtool", "check", "rules", str(ALERTS), str(path)], check=True, capture_output=True
    )
