import mmap
import os

import pytest

from service.building.memory import private_bytes


def test_only_what_was_touched_and_belongs_to_the_process_counts(tmp_path):
    size = 64 << 20
    (tmp_path / "file").write_bytes(bytes(size))
    before = private_bytes("self")
    with (tmp_path / "file").open("rb") as file:
        mapped = mmap.mmap(file.fileno(), size, access=mmap.ACCESS_READ)
        assert sum(mapped[::4096]) == 0
        assert private_bytes(os.getpid()) - before < size / 2
        mapped.close()
    reserved = mmap.mmap(-1, size, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    assert private_bytes("self") - before < size / 2
    for place in range(0, size, 4096):
        reserved[place] = 1
    assert private_bytes("self") - before > size * 0.9
    reserved.close()


@pytest.mark.parametrize("process", [0, "none"])
def test_of_no_process_nothing_is_known(process):
    assert private_bytes(process) is None
