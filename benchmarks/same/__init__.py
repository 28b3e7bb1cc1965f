"""Compare what users see of this revision and of an earlier one: ``make same BEFORE=REVISION``."""
