"""A server that answers as Google Cloud Storage's XML API is documented to, for obstore's client.

No emulator of it honours the conditions of writes, which is what the store relies on. This one does
what the documentation says of ``x-goog-if-generation-match``, ``x-goog-generation`` and
``x-goog-copy-source``, and so shows that our requests carry them and their answers are understood:
not what Google does.
"""

import contextlib
import hashlib
import http.server
import itertools
import json
import threading
from email.utils import formatdate
from urllib.parse import parse_qs, unquote, urlsplit
from xml.sax.saxutils import escape


class Handler(http.server.BaseHTTPRequestHandler):
    """Objects in memory, each with its generation."""

    protocol_version = "HTTP/1.1"
    objects: dict[str, tuple[bytes, int]]
    lock: threading.Lock
    generations: itertools.count

    def do_GET(self):
        address = urlsplit(self.path)
        if "list-type" in parse_qs(address.query):
            return self.listed({name: value[0] for name, value in parse_qs(address.query).items()})
        found = self.objects.get(unquote(address.path))
        return self.answer(404) if found is None else self.answer(200, *found)

    do_HEAD = do_GET  # noqa: N815 - the name it calls

    def do_PUT(self):
        body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
        name, wanted = (
            unquote(urlsplit(self.path).path),
            self.headers.get("x-goog-if-generation-match"),
        )
        with self.lock:
            if source := self.headers.get("x-goog-copy-source"):
                found = self.objects.get("/" + unquote(source).lstrip("/"))
                if found is None:
                    return self.answer(404)
                body = found[0]
            if wanted is not None and int(wanted) != self.objects.get(name, (b"", 0))[1]:
                return self.answer(412)
            generation = next(self.generations)
            self.objects[name] = body, generation
        return self.answer(200, b"<CopyObjectResult/>" if source else b"", generation, body)

    def do_DELETE(self):
        with self.lock:
            found = self.objects.pop(unquote(urlsplit(self.path).path), None)
        self.answer(404 if found is None else 204)

    def listed(self, query):
        bucket = unquote(urlsplit(self.path).path).rstrip("/") + "/"
        after = query.get("continuation-token") or query.get("start-after", "")
        names = sorted(
            name.removeprefix(bucket)
            for name in list(self.objects)
            if name.startswith(bucket + query.get("prefix", ""))
        )
        names = [name for name in names if name > after]
        page = names[: min(int(query.get("max-keys", 1000)), 7)]  # so that there are pages
        xml = "".join(
            f"<Contents><Key>{escape(name)}</Key><Size>1</Size>"
            "<LastModified>2026-01-01T00:00:00.000Z</LastModified></Contents>"
            for name in page
        )
        if len(names) > len(page):
            xml += f"<NextContinuationToken>{escape(page[-1])}</NextContinuationToken>"
        self.answer(200, f"<ListBucketResult>{xml}</ListBucketResult>".encode(), 1)

    def answer(self, status, body=b"", generation=None, content=None):
        self.send_response(status)
        self.send_header("Content-Length", str(len(body)))
        if generation is not None:
            digest = hashlib.md5(body if content is None else content, usedforsecurity=False)
            self.send_header("ETag", f'"{digest.hexdigest()}"')
            self.send_header("x-goog-generation", str(generation))
            self.send_header("Last-Modified", formatdate(usegmt=True))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def log_message(self, *_):
        """Say nothing."""


@contextlib.contextmanager
def server():
    """Such a server on a free port; yields the environment that obstore finds it with."""
    state = {"objects": {}, "lock": threading.Lock(), "generations": itertools.count(1)}
    running = http.server.ThreadingHTTPServer(("127.0.0.1", 0), type("Google", (Handler,), state))
    running.daemon_threads = True
    thread = threading.Thread(target=running.serve_forever, daemon=True)
    thread.start()
    account = {
        "gcs_base_url": f"http://127.0.0.1:{running.server_port}",
        "disable_oauth": True,
        "client_email": "",
        "private_key": "",
        "private_key_id": "",
    }
    try:
        yield {
            "GOOGLE_SERVICE_ACCOUNT_KEY": json.dumps(account),
            "GOOGLE_ALLOW_HTTP": "true",
        }
    finally:
        running.shutdown()
        running.server_close()
        thread.join()
