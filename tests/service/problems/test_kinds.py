from gamutcore import errors
from service.problems.kinds import KINDS


def test_every_error_of_gamutcore_has_one_row_that_blames_the_content():
    codes = {getattr(errors, name).code for name in errors.__all__}
    assert codes <= set(KINDS)
    assert {KINDS[code].status for code in codes} == {422}
