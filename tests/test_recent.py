"""Results that are kept for a while: the last ones, up to a number of bytes."""

from lostmotion.recent import Recent


def test_a_result_is_computed_once_while_it_is_kept():
    """A second request for a key returns the object of the first one."""
    recent = Recent[bytes](100, len)
    first = recent.of("a", lambda: b"first")
    assert recent.of("a", lambda: b"second") is first


def test_the_results_used_last_are_kept():
    """Where the bytes do not suffice, the result goes that was not used for the longest time."""
    recent = Recent[bytes](10, len)
    for key in "ab":
        recent.of(key, lambda: b"1234")
    recent.of("a", lambda: b"not computed")
    recent.of("c", lambda: b"1234")
    assert recent.of("a", lambda: b"") == b"1234"
    assert recent.of("c", lambda: b"") == b"1234"
    assert recent.of("b", lambda: b"5678") == b"5678"


def test_a_result_larger_than_the_store_is_returned_and_not_kept():
    """It would push out all others, and yet not be kept whole."""
    recent = Recent[bytes](10, len)
    recent.of("a", lambda: b"1234")
    assert recent.of("b", lambda: bytes(11)) == bytes(11)
    assert recent.of("b", lambda: b"5678") == b"5678"
    assert recent.of("a", lambda: b"") == b"1234"
