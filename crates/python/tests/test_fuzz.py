"""Ten thousand random calls; `fuzz.py` makes a million."""

import fuzz


def test_random_calls_return_or_say_why():
    refused = fuzz.run(10_000, seed=1)
    assert 1_000 < refused < 9_000
