"""The kinds of problems with content are those of the errors of `gamutcore`."""

from gamutcore import errors
from service.problems.content_kinds import CONTENT_KINDS


def test_every_error_has_a_kind_of_its_code_and_no_other_kind_exists():
    codes = {getattr(errors, name).code for name in errors.__all__}
    assert {kind.code for kind in CONTENT_KINDS} == codes


def test_all_are_faults_of_the_content_with_an_example_and_a_remedy():
    for kind in CONTENT_KINDS:
        assert kind.status == 422
        assert all((kind.title, kind.remedy, kind.detail))
