import pytest

from service.building.interruption import Interrupted, Interruption


def test_nothing_ends_until_it_is_told_to():
    interruption = Interruption()
    interruption.check()
    interruption.release()
    with pytest.raises(Interrupted) as caught:
        interruption.check()
    assert caught.value.reason == "release"


@pytest.mark.parametrize("order", [["cancel", "release"], ["release", "cancel"]])
def test_what_nobody_wants_is_not_given_to_another(order):
    interruption = Interruption()
    for word in order:
        getattr(interruption, word)()
    with pytest.raises(Interrupted) as caught:
        interruption.check()
    assert caught.value.reason == "cancel"
