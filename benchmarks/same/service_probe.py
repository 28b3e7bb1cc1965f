"""Observe the service of a revision through HTTP, its commands, its log and its store.

``python -m benchmarks.same.service_probe INPUTS RESULTS AREA...``. The environment variable
``SAME_GAMUT`` names the command, and ``SAME_PACKAGES`` a folder of packages with httpx.
"""

from __future__ import annotations

import collections
import contextlib
import hashlib
import http.client
import io
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.same.observations import Observations

__all__ = ["AREAS", "SERVER_AREAS", "main", "serving"]

SERVER_AREAS = ("http", "metrics", "log", "store", "client")
AREAS = (*SERVER_AREAS, "commands")
"""What is observed, by name. The areas of the server are observed together."""

PATIENCE = 600.0
"""Seconds after which a server or an answer is given up."""

KEY = "a-key-for-the-comparison"

STRICT = {
    "api_keys": f"reader:read:{hashlib.sha256(KEY.encode()).hexdigest()}",
    "allow_anonymous": "read",
    "cors_origins": "https://example.org",
    "max_body_bytes": "100000",
    "build_queue": "1",
}

VOLATILE = (
    (re.compile(r"\b20\d\d-\d\d-\d\dT[\d:.]+(?:Z|[+-]\d\d:\d\d)?"), "TIME"),
    (re.compile(r"127\.0\.0\.1:\d+"), "HOST"),
    (re.compile(r"[\d.]+ [kMGT]i?B are free"), "# are free"),
    (re.compile(r"[\d.]+ MB/s"), "# MB/s"),
    (re.compile(r"(dur=)[\d.]+"), r"\1#"),
    (re.compile(r"\b(\d+(?:\.\d+)?|about \d+) (s|seconds|ms)\b"), "# s"),
)

STORED = (
    (re.compile(rb"\b20\d\d-\d\d-\d\dT[\d:.]+Z"), b"TIME"),
    (re.compile(rb"\A[0-9a-f]{64}\n|\b[0-9a-f]{16}\b"), b"DIGEST"),
)

VOLATILE_KEYS = {
    "seconds",
    "milliseconds",
    "elapsed",
    "started",
    "created",
    "finished",
    "updated",
    "memory_bytes",
}

DESCRIPTION = re.compile(r"/v1/gamuts/[^/?]+")
"""The address of a description, which has the time of its creation."""

Headers = dict[str, str]

PAGES = """/ /view /docs /redoc /openapi.json /problems /problems/invalid-option /problems/nothing
/livez /readyz /metrics /v1/references /v1/gamuts /v1/gamuts?limit=2 /v1/gamuts?limit=0 /v1/gamuts/
/v1/gamuts?name=pap /v1/gamuts?after=x /v1/gamuts?nothing=1 /v1/nothing /favicon.ico /static/nothing
/%2e%2e/etc/passwd"""

VIEWS = """mesh mesh?triangles=3
mesh?triangles=1e3 mesh?triangles=100&triangles=50 mesh?max_error=-1
mesh?max_error=1&max_mismatch=0.01 mesh?triangles=100&max_error=1 mesh?side=inside&triangles=90
mesh.ply?side=outside&max_error=2 mesh?side=left mesh?colour=1 levels?side=inside cusps cusps?hues=0
leaves?hues=8&lightness=5 slice slice?lightness=50 slice?hue=40 slice?plane=1,0,0,50 slice?plane=1,0
slice?lightness=50&hue=3 slice?hue=40&triangles=100 rings viewer.html
rings?sectors=12&reference=srgb rings?sectors=36 rings?reference=nothing picture.png?size=64
picture.png?size=5 picture.png?view=top&size=64 picture.png?view=1,2,3 picture.png?background=red
mesh?space=Oklab mesh.glb?triangles=60 mesh.gltf?triangles=60 mesh.ply?triangles=60
mesh.stl?triangles=60 mesh.obj?triangles=60 mesh.3mf?triangles=60 mesh.gam?triangles=60
mesh.icc?triangles=60 mesh.cge?triangles=60 mesh.fbx mesh?format=fbx mesh?format=cge&max_error=3"""

OTHERS = """/v1/gamuts/srgb /v1/gamuts/sRGB /v1/gamuts/srgbb /v1/gamuts/srgb?surface_samples=2000
/v1/gamuts/srgb/mesh?triangles=50&space=Oklab&surface_samples=2000 /v1/gamuts/srgb?gamma=7
/v1/gamuts/pointer/slice?lightness=40 /v1/comparisons?a=srgb&b={press}&sectors=4 /v1/comparisons
/v1/comparisons?a=srgb /v1/comparisons?a={oklab}&b={press} /v1/comparisons?a=x&b=y"""

QUERIES = """contains contains?distance=true contains?tolerance=2 contains?triangles=100
contains?x=1 contains?max_error=0 contains?space=LCHab contains?space=x nearest
nearest?metric=CIE%202000 nearest?metric=x map map?method=clip-focal&focus=cusp
map?method=clip-nearest map?method=clip-hue map?method=clip-lightness map?method=clip-chroma
map?method=sgck&source=srgb map?method=x"""

CONDITIONS = """If-None-Match If-Match Accept-Encoding:gzip Accept-Encoding:zstd
Accept-Encoding:br;q=1,gzip;q=0.5 Accept-Encoding:identity;q=0 Accept-Encoding:gzip;q=0,*;q=0
Range:bytes=0-99 Range:bytes=100- Range:bytes=-50 Range:bytes=99999999- Range:bytes=5-2
Range:bytes=0-1,5-9 Range:x Accept:model/stl Accept:application/ply;q=0.5,model/obj Accept:image/png
Accept:text/csv Accept:application/json Accept:bad X-Request-Id:a!b traceparent:x"""

ROWS = [[0, 0, 0], [100, 0, 0], [50, 60, 0], [50, -30, 52], [50, -30, -52]]

INLINE: tuple[object, ...] = (
    {"samples": ROWS},
    {"samples": ROWS, "options": {"gamma": 1}, "name": "Five"},
    {"samples": ROWS, "gamma": 1},
    {"samples": ROWS[:2]},
    {"samples": [[1, 2], [3]]},
    {"samples": ROWS, "options": {"cost": "x"}},
    {"reference": "srgb", "options": {"surface_samples": 2000, "space": "Oklab"}},
    {"reference": "srgbb"},
    {"name": "nothing"},
    [1, 2],
    b"{",
    b'{"samples": [], "samples": []}',
)

RAW = (
    b"nonsense\r\n\r\n",
    b"GET / HTTP/1.1\r\n\r\n",
    b"GET /livez HTTP/1.0\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: localhost\r\nbad field\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"x" * 40_000 + b"\r\n\r\n",
    b"POST /v1/gamuts HTTP/1.1\r\nHost: localhost\r\nContent-Length: x\r\n\r\n",
    b"POST /v1/gamuts HTTP/1.1\r\nHost: localhost\r\nContent-Length: 999999999999\r\n\r\n",
)

COMMANDS = """--version|nothing|build|reference|reference srgb --json|reference nothing|openapi
build cmyk.txt --surface-samples 3000 --ink-limit 300 -o coated.gamut|info coated.gamut
info coated.gamut --json|info cmyk.icc --surface-samples 1000|mesh coated.gamut -o out.fbx
mesh coated.gamut --triangles 300 -o out.glb|mesh coated.gamut --max-error 2 -o out.ply
export coated.gamut --table cusps --csv|export coated.gamut --table levels --json
export coated.gamut --table leaves -o leaves.csv|export coated.gamut -o page.html
export coated.gamut --table nothing|query spots.csv --gamut coated.gamut
query spots.csv --gamut coated.gamut --json --triangles 200|slice coated.gamut
query spots.csv --gamut coated.gamut --metric x|slice coated.gamut --hue 40 -o leaf.csv
query lab.npy --gamut coated.gamut -o report.csv --colours-in CIELAB|rings coated.gamut --csv
compare coated.gamut srgb --surface-samples 2000|rings coated.gamut -o rings.json
compare coated.gamut srgb --surface-samples 2000 --json|slice coated.gamut --lightness 50 --csv
map spots.csv --gamut coated.gamut --method clip-chroma|store list checked
map rgb.png --gamut coated.gamut -o printable.png|picture coated.gamut --size 3 -o tiny.png
map rgb.png --gamut coated.gamut -o printable.gif|picture coated.gamut --size 64 -o small.png
serve --print-settings|serve --port 99999|key press --scopes read
key Press!|worker --check|info nothing.ti3|info broken.gamut|info rgb.png --ink-limit 300
info cmyk.txt --ink-limt 300|info cmyk.txt --gamma 7|info coated.gamut --gamma 0.1"""

HELP = """build info mesh export reference query compare map slice rings picture serve worker
key openapi warm store"""


class Answer(NamedTuple):
    """Status, header fields and body of an answer."""

    status: int
    fields: list[tuple[str, str]]
    body: bytes

    def field(self, name: str) -> str:
        """Return the value of a header field, or an empty text."""
        return next((value for field, value in self.fields if field.lower() == name), "")


class Server:
    """A running server, whose answers are recorded.

    Parameters
    ----------
    port : int
    process : subprocess.Popen
    found : Observations
    """

    def __init__(self, port: int, process: subprocess.Popen[bytes], found: Observations) -> None:
        self.port, self.process, self.found = port, process, found
        self.prefix, self.count = "", 0

    def ask(
        self,
        path: str,
        method: str = "GET",
        headers: Headers | None = None,
        body: bytes | None = None,
        title: str = "",
    ) -> Answer:
        """Send a request and record the answer without what differs from run to run."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        sent = {"X-Request-Id": "same", "Prefer": "wait=300", **(headers or {})}
        connection.request(method, path, body, sent)
        response = connection.getresponse()
        answer = Answer(response.status, response.getheaders(), response.read())
        connection.close()
        self.count += 1
        shown = " ".join(f"{k}: {v:.150}" for k, v in (headers or {}).items())
        text = re.sub(r"[0-9a-f]{64}", "ID", f"{method} {path:.250} {shown} {title}").strip()
        name = f"{self.prefix}{self.count:03d} {text}"
        self.found.record(f"{name}: head", [answer.status, *self._fields(path, answer)])
        self.found.record(f"{name}: body", self._body(path, answer))
        return answer

    def _fields(self, path: str, answer: Answer) -> list[str]:
        digest = hashlib.sha256(answer.body).hexdigest()
        lines = []
        for name, given in answer.fields:
            value = normal(given).replace(digest, "SHA-256 of the body")
            if name.lower() == "content-length" and value == str(len(answer.body)):
                value = "length of the body"
            if name.lower() == "date" or (name.lower() == "x-request-id" and value != "same"):
                value = "#"
            if name.lower() in {"retry-after", "ratelimit"}:
                value = re.sub(r"\d+", "#", value)
            if name.lower() == "etag" and DESCRIPTION.fullmatch(path):
                value = re.sub(r"[0-9a-f]{64}", "TAG", value)  # of a text with a time
            lines.append(f"{name}: {value}")
        return lines

    def _body(self, path: str, answer: Answer) -> object:
        if "json" in answer.field("content-type") and not answer.field("content-encoding"):
            with contextlib.suppress(ValueError):
                return plain(json.loads(answer.body))
        if answer.field("content-type").startswith("text/event-stream"):  # how many depends on time
            lines = normal(answer.body.decode()).split("\n")
            events = sorted({line for line in lines if line.startswith("event")})
            last = [line for line in lines if line.startswith("data")][-1]
            return [events, plain(json.loads(last[5:]))]
        if answer.field("content-encoding") and DESCRIPTION.fullmatch(path):
            return "compressed"
        if path == "/metrics":
            return _samples(answer)
        try:
            return normal(answer.body.decode())
        except UnicodeDecodeError:
            return answer.body

    def post(self, path: str, body: object, kind: str, **headers: str) -> Answer:
        """Post bytes of a media type, or a JSON value."""
        content = body if isinstance(body, bytes) else json.dumps(body).encode()
        return self.ask(path, "POST", {"Content-Type": kind, **headers}, content, f"{body!r:.70}")

    def build(self, file: Path, options: object = None, **more: str) -> str:
        """Post a file as a form and return the id, or an empty text."""
        fields = {**({"options": json.dumps(options)} if options is not None else {}), **more}
        parts = [
            f'--b\r\nContent-Disposition: form-data; name="{k}"\r\n\r\n{v}\r\n'.encode()
            for k, v in fields.items()
        ]
        head = f'--b\r\nContent-Disposition: form-data; name="file"; filename="{file.name}"\r\n\r\n'
        body = b"".join([*parts, head.encode(), file.read_bytes(), b"\r\n--b--\r\n"])
        headers = {"Content-Type": "multipart/form-data; boundary=b", "Prefer": "wait=300"}
        answer = self.ask("/v1/gamuts", "POST", headers, body, f"{file.name} {options} {more}")
        with contextlib.suppress(ValueError):
            return str(json.loads(answer.body).get("id", ""))
        return ""


def _samples(answer: Answer) -> list[str]:
    """Return the lines of metrics without their values, and without runs of buckets."""
    text = re.sub(r"(?<=[ }])[-+.\de]+( [\d.]+)?$", "", answer.body.decode(), flags=re.MULTILINE)
    return sorted({normal(line) for line in text.split("\n") if "_bucket{" not in line})


def normal(text: str) -> str:
    """Return a text without times and ports."""
    for pattern, put in VOLATILE:
        text = pattern.sub(put, text)
    return text


def plain(value: Any) -> Any:  # noqa: ANN401
    """Return a JSON value without times and ports."""
    if isinstance(value, dict):
        return {
            normal(key): "#" if key in VOLATILE_KEYS and item is not None else plain(item)
            for key, item in value.items()
        }
    if isinstance(value, list):
        return [plain(item) for item in value]
    return normal(value) if isinstance(value, str) else value


@contextlib.contextmanager
def serving(folder: Path, found: Observations, settings: Headers) -> Iterator[Server]:
    """Run a server with its store and log in a folder until all of its kernels are ready."""
    folder.mkdir(parents=True)
    given = {"log_format": "json", "access_log": "true", **settings}
    environment = {**os.environ, **{f"GAMUT_{k.upper()}": v for k, v in given.items()}}
    command = [os.environ["SAME_GAMUT"], "serve", "--port", "0", "--store", str(folder / "store")]
    log = folder / "log"
    with log.open("wb") as output:
        process = subprocess.Popen(command, stdout=output, stderr=output, env=environment)
    try:
        port, end = 0, time.monotonic() + PATIENCE
        while True:
            if process.poll() is not None or time.monotonic() > end:
                raise RuntimeError(log.read_text())
            address = re.search(r"http://127\.0\.0\.1:(\d+)", log.read_text())
            port = int(address[1]) if address else 0
            with contextlib.suppress(OSError):
                connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
                connection.request("GET", "/readyz")
                if port and connection.getresponse().status == 200:
                    break
            time.sleep(0.05)
        yield Server(port, process, found)
    finally:
        process.terminate()
        process.wait(PATIENCE)


def main() -> None:
    """Observe the areas that the command line names."""
    inputs, results, areas = Path(sys.argv[1]), Path(sys.argv[2]), set(sys.argv[3:])
    observations = {area: Observations(results, area) for area in areas}
    if "commands" in areas:
        observe_commands(inputs, observations["commands"])
    if areas & set(SERVER_AREAS):
        every = {area: Observations(results, area) for area in SERVER_AREAS} | observations
        observe_server(inputs, results, every)
    for found in observations.values():
        found.save()


def observe_server(inputs: Path, results: Path, found: dict[str, Observations]) -> None:
    """Ask a server with default settings, and a strict one; then read log and store."""
    folder = results / "serving"
    shutil.rmtree(folder, ignore_errors=True)
    with serving(folder / "open", found["http"], {}) as server:
        ids = _build_all(server, inputs)
        _read_all(server, ids)
        _query_all(server, ids)
        _send_raw(server)
        _observe_client(server.port, inputs, found["client"])
        server.ask(f"/v1/gamuts/{ids['picture']}", "DELETE")
        server.ask(f"/v1/gamuts/{ids['picture']}")
        for line in _samples(server.ask("/metrics")):
            found["metrics"].record(line, True)
    with serving(folder / "strict", found["http"], STRICT) as server:
        server.prefix = "strict "
        _ask_strict(server, inputs)
    for name in ("open", "strict"):
        keys: dict[str, set[str]] = collections.defaultdict(set)
        for line in (folder / name / "log").read_text(errors="replace").splitlines():
            try:
                event = json.loads(line)
            except ValueError:  # of a library in C, which does not know the log
                found["log"].record(f"{name}: {line:.30}", "not JSON")
                continue
            text = event["message"].split("\n")[0]
            text = re.sub(r"[0-9a-f]{64}|'[^']*'|/\S*|[\d.]+", "#", text)
            text = f"{event['method']} request" if "method" in event else text
            keys[f"{event['level']} {text}"] |= set(event)
        for text, names in keys.items():
            found["log"].record(f"{name}: {text}", sorted(names))
        paths: collections.Counter[str] = collections.Counter()
        for path in sorted((folder / name / "store").rglob("*")):
            place = str(path.relative_to(folder / name / "store"))
            place = re.sub(r"\b[0-9a-f]{16}\b", "DIGEST", place)  # of a file with a time
            paths[re.sub(r"[0-9a-f]{64}", "ID", place)] += 1
            if path.is_file():
                found["store"].record(f"{name}: {place}", _stored(path.read_bytes()))
        found["store"].record(f"{name}: layout", dict(sorted(paths.items())))


def _stored(content: bytes) -> bytes:
    """Return a stored file without its times and the digests that depend on them."""
    for pattern, put in STORED:
        content = pattern.sub(put, content)
    return content


def _build_all(server: Server, inputs: Path) -> dict[str, str]:
    """Build gamuts in all ways, and fail to; return the ids of some."""
    files, small = inputs / "files", {"surface_samples": 3000}
    ids = {
        "press": server.build(files / "FOGRA39L.ti3", {**small, "ink_limit": 300}, name="Paper"),
        "display": server.build(files / "sRGB-v4.icc", small),
        "picture": server.build(files / "rgb.png", {}),
        "oklab": server.build(files / "lch.csv", {"space": "Oklab"}),
        "mesh": server.build(files / "mesh-device.ply"),
    }
    server.build(files / "FOGRA39L.ti3", {**small, "ink_limit": 300})
    server.build(files / "7inks.txt", small, gamma="0.5")
    server.build(files / "7inks.txt", {"gamma": 0.2}, gamma="0.5")
    server.build(files / "rgb.csv", small, unknown="1")
    for options in json.loads((inputs / "wrong.json").read_text())[::3]:
        server.build(files / "cmyk.txt", {**small, **options})
    for damaged in sorted((inputs / "damaged").iterdir())[::9]:
        server.build(damaged)
    for body in INLINE:
        server.post("/v1/gamuts", body, "application/json", Prefer="wait=300")
    for kind in ("text/plain", "multipart/form-data; boundary=b", "multipart/form-data"):
        server.post("/v1/gamuts", b"--b--", kind)
    body = {"samples": [*ROWS, [9, 1, 2]]}
    job = server.post("/v1/gamuts", body, "application/json", Prefer="respond-async")
    place = job.field("location")
    for path in (f"{place}/events", place, "/v1/jobs?limit=2", "/v1/jobs", "/v1/jobs/x"):
        server.ask(path)
    server.ask(place, "DELETE")
    return ids


def _read_all(server: Server, ids: dict[str, str]) -> None:
    """Read every route, in all forms, with conditions, ranges and faults."""
    press = f"/v1/gamuts/{ids['press']}"
    for path in PAGES.split():
        for accept in ("*/*", "text/html"):
            server.ask(path, headers={"Accept": accept})
    for gamut_id in ids.values():
        for path in ("", "/levels", "/history", "/mesh?triangles=100", "/cusps?hues=6"):
            server.ask(f"/v1/gamuts/{gamut_id}{path}")
    for view in VIEWS.split():
        server.ask(f"{press}/{view}")
    server.ask(f"/v1/gamuts/{ids['display']}/mesh.cge")
    for path in OTHERS.split():
        server.ask(path.format(**ids))
    for path in (press, f"{press}/mesh?triangles=200", f"{press}/history", f"{press}/cusps?hues=4"):
        tag = server.ask(path, "HEAD").field("etag")
        for condition in CONDITIONS.split():
            field, _, value = condition.partition(":")
            for given in [value] if value else [tag, '"x"', "*", f'W/{tag}, "y"', "bad"]:
                server.ask(path, headers={field: given})
        for method in ("OPTIONS", "POST", "PUT", "PATCH"):
            server.ask(path, method)
    headers = {"Content-Type": "application/json"}
    for body in ({"name": "New name"}, {"name": ""}, {"name": 3}, {}, {"name": "x\u0007"}):
        server.ask(f"{press}/name", "PUT", headers, json.dumps(body).encode(), str(body))
    server.ask("/v1/gamuts/srgb", "DELETE")
    server.ask(press, "DELETE", {"If-Match": '"x"'})


def _query_all(server: Server, ids: dict[str, str]) -> None:
    """Post colours in all forms to all queries."""
    colours = np.random.default_rng(1).uniform((0, -90, -90), (100, 90, 90), (50, 3)).round(3)
    file = io.BytesIO()
    np.save(file, colours)
    rows = colours.tolist()
    table = "name,L*,a*,b*\n" + "".join(f"c{i},{a},{b},{c}\n" for i, (a, b, c) in enumerate(rows))
    forms = {"application/json": {"colours": rows}, "application/x-npy": file.getvalue()}
    press = f"/v1/gamuts/{ids['press']}"
    for query in QUERIES.split():
        for kind, body in (*forms.items(), ("text/csv", table.encode())):
            server.post(f"{press}/{query}", body, kind)
    for kind in ("segment", "ray", "line", "arc"):
        lines = {"from": rows, "to": rows[::-1], "kind": kind}
        for accept in ("*/*", "text/csv"):
            server.post(f"{press}/crossings", lines, "application/json", Accept=accept)
    for name in ("display", "oklab", "mesh"):
        server.post(f"/v1/gamuts/{ids[name]}/nearest", {"colours": rows}, "application/json")
    bad: tuple[object, ...] = ({}, {"colours": []}, {"colours": [[1, "x", 2]]}, [], 3, b"{")
    for content in bad:
        server.post(f"{press}/contains", content, "application/json")
    for content in (b"\x93NUMPY", b"L,a\n1,2\n", b"L,a,b\n1,2,x\n"):
        for kind in ("application/x-npy", "text/csv", "text/plain"):
            server.post(f"{press}/nearest", content, kind)
    for accept in ("application/x-npy", "text/csv", "image/png"):
        server.post(f"{press}/nearest", {"colours": rows}, "application/json", Accept=accept)
    server.post("/v1/gamuts/srgbb/contains", {"colours": rows}, "application/json")


def _send_raw(server: Server) -> None:
    """Send requests that are no HTTP."""
    for sent in RAW:
        with socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE) as connection:
            connection.sendall(sent)
            connection.shutdown(socket.SHUT_WR)
            received = b""
            while part := connection.recv(65536):
                received += part
        text = re.sub(r"(?im)^(x-request-id|date): .*", r"\1: #", normal(received.decode()))
        text = re.sub(r'("request_id": ?")[^"]*', r"\1#", text)
        server.found.record(f"raw {sent[:60]!r}", text)


def _ask_strict(server: Server, inputs: Path) -> None:
    """Meet the limits of settings, keys and scripts of other origins."""
    keys: tuple[Headers, ...] = ({"Authorization": f"Bearer {KEY}"}, {"X-Api-Key": KEY})
    for headers in (*keys, {}, {"X-Api-Key": "x"}, {"Authorization": "Basic x"}):
        server.ask("/v1/gamuts", headers=headers)
        server.ask("/v1/gamuts", "POST", {**headers, "Content-Type": "application/json"}, b"{}")
    for origin in ("https://example.org", "https://example.com"):
        for method in ("GET", "OPTIONS"):
            headers = {"Origin": origin, "Access-Control-Request-Method": "POST"}
            server.ask("/v1/references", method, headers)
    server.build(inputs / "files" / "FOGRA39L.ti3")
    server.ask("/v1/gamuts?limit=9")
    server.ask("/v1/gamuts/srgb?surface_samples=200000")
    server.ask("/v1/gamuts", headers={"X": "x" * 5000})


def _observe_client(port: int, inputs: Path, found: Observations) -> None:
    """Use the client of the revision."""
    sys.path.append(os.environ["SAME_PACKAGES"])  # last: httpx, if it is not installed
    import gamutclient

    client = gamutclient.Client(f"http://127.0.0.1:{port}")
    gamut: Any = client.build(str(inputs / "files" / "cmyk.txt"), surface_samples=3000)
    other: Any = client.reference("srgb")
    colours = np.random.default_rng(2).uniform((0, -90, -90), (100, 90, 90), (200, 3))
    calls: tuple[tuple[str, tuple[Any, ...], dict[str, Any]], ...] = (
        ("contains", (colours,), {}),
        ("distance", (colours,), {"triangles": 300}),
        ("classify", (colours,), {"tolerance": 2}),
        ("nearest", (colours,), {"metric": "CIE 2000"}),
        ("map", (colours, "sgck"), {"source": other}),
        ("crossings", (colours, colours[::-1]), {"kind": "line"}),
        ("cusps", (12,), {}),
        ("max_chroma", (colours[:, 0], np.abs(colours[:, 1])), {}),
        ("slice", (50,), {}),
        ("leaves", (8, 5), {}),
        ("rings", (other,), {"sectors": 12}),
        ("compare", (other,), {}),
        ("coverage_of", (other,), {}),
        ("__and__", (other,), {}),
        ("mesh", (100,), {}),
        ("to_bytes", (), {}),
        ("picture", (64,), {}),
        ("nothing", (), {}),
    )
    for method, args, named in calls:
        found.attempt(method, lambda m=method: getattr(gamut, m)(*args, **named))  # noqa: B023
    found.record("texts", [repr(gamut), repr(other), gamut.id, gamut.volume, gamut.channels])
    found.attempt("references", client.references)
    found.attempt("unknown", client.gamut, "0" * 64)
    found.attempt("bad colours", gamut.contains, [[0, 0, np.nan]])
    found.attempt("bad data", client.build, b"nothing")
    client.close()


def observe_commands(inputs: Path, found: Observations) -> None:
    """Run every command: help, results in all forms, files written, and faults."""
    folder = found.folder / "commands"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(inputs / "files", folder)
    (folder / "broken.gamut").write_bytes(b"GAMUT")
    written = set(folder.iterdir())
    words = [f"{name} --help" for name in HELP.split()]
    for command in ["--help", *words, "store list --help", *re.split(r"[|\n]", COMMANDS)]:
        line = [os.environ["SAME_GAMUT"], *command.split()]
        done = subprocess.run(line, cwd=folder, capture_output=True, check=False)
        output = [normal(text.decode(errors="replace")) for text in (done.stdout, done.stderr)]
        if command.startswith("key "):
            output = [re.sub(r"(?<=client:)\s+\S+|[0-9a-f]{64}", " KEY", text) for text in output]
        found.record(command, [done.returncode, *output])
        for path in sorted(set(folder.iterdir()) - written):
            written.add(path)
            if path.is_file():
                found.record(f"{command}: {path.name}", path.read_bytes())


if __name__ == "__main__":
    main()
