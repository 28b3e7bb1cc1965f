from gamutcore import errors
from service.problems.core_problems import CORE_KINDS


def test_every_error_of_gamutcore_has_one_row_that_blames_the_content():
    codes = [kind.code for kind in CORE_KINDS]
    assert sorted(codes) == sorted({getattr(errors, name).code for name in errors.__all__})
    assert {kind.status for kind in CORE_KINDS} == {422}
