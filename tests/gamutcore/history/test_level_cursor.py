"""Stepping in place gives the same levels as reading them, bit for bit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gamutcore.errors import TriangleCountError


def assert_at(cursor, history, triangles):
    assert cursor.triangles == triangles
    level = history.level(triangles)
    assert cursor.mesh.vertices.tobytes() == level.vertices.tobytes()
    assert cursor.mesh.faces.tobytes() == level.faces.tobytes()


class TestOneStep:
    def test_up_from_four_triangles_to_the_full_boundary_and_down_again(self, small_history):
        cursor = small_history.cursor(4)
        counts = range(4, small_history.triangles + 1, 2)
        for count in counts:
            assert_at(cursor, small_history, count)
            if count < small_history.triangles:
                cursor.finer()
        for count in reversed(counts):
            assert_at(cursor, small_history, count)
            if count > 4:
                cursor.coarser()


class TestManySteps:
    @settings(max_examples=60)
    @given(targets=st.lists(st.floats(0, 1), min_size=1, max_size=12))
    def test_any_number_of_steps(self, small_history, targets):
        cursor = small_history.cursor(50)
        for target in targets:
            count = 4 + 2 * round(target * (small_history.vertices - 4))
            steps = (count - cursor.triangles) // 2
            if steps >= 0:
                cursor.finer(steps)
            else:
                cursor.coarser(-steps)
            assert_at(cursor, small_history, count)

    def test_from_end_to_end_of_a_large_gamut(self, fogra39_gamut):
        history = fogra39_gamut.history
        cursor = history.cursor(history.triangles)
        for count in (10_000, 500, 4, 5000, history.triangles, 4, history.triangles):
            steps = (count - cursor.triangles) // 2
            (cursor.finer if steps > 0 else cursor.coarser)(abs(steps))
            assert_at(cursor, history, count)


class TestEnds:
    @pytest.mark.parametrize("steps", [1, 2, 10**6])
    def test_steps_beyond_the_ends_change_nothing(self, small_history, steps):
        cursor = small_history.cursor(4)
        with pytest.raises(TriangleCountError) as caught:
            cursor.coarser(steps)
        assert caught.value.where == {"field": "steps"}
        assert_at(cursor, small_history, 4)
        cursor = small_history.cursor(small_history.triangles)
        with pytest.raises(TriangleCountError):
            cursor.finer(steps)
        assert_at(cursor, small_history, small_history.triangles)

    def test_too_many_steps_from_the_middle_change_nothing(self, small_history):
        cursor = small_history.cursor(100)
        for move in (cursor.finer, cursor.coarser):
            with pytest.raises(TriangleCountError):
                move(small_history.vertices)
            assert_at(cursor, small_history, 100)
        cursor.finer()
        assert_at(cursor, small_history, 102)


class TestCursor:
    def test_a_cursor_does_not_change_the_history(self, small_history):
        before = [array.copy() for array in small_history.splits]
        levels = [small_history.level(n) for n in (4, 20, small_history.triangles)]
        cursor = small_history.cursor(4)
        cursor.finer(small_history.vertices - 4)
        cursor.mesh.vertices[:] = 0
        cursor.mesh.faces[:] = 0
        for array, copy in zip(small_history.splits, before, strict=True):
            np.testing.assert_array_equal(array, copy)
        assert levels == [small_history.level(n) for n in (4, 20, small_history.triangles)]
