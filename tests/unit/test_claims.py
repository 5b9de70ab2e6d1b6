"""Claims on kernels, with a dictionary for Numba's cache: who comes first compiles, others wait and read."""

import threading

import pytest

from viscorod.mechanics.compilation import claims
from viscorod.mechanics.compilation.claims import ClaimedCache


class Disk:
    def __init__(self):
        self.content = {}

    def load_overload(self, signature, target_context):
        return self.content.get(signature)

    def save_overload(self, signature, data):
        self.content[signature] = data


@pytest.fixture
def pair(tmp_path):
    """The caches of one kernel in two processes: each opens the file of the claim itself."""
    disk = Disk()
    return [ClaimedCache(disk, tmp_path / "kernel.claim") for _ in range(2)]


def test_the_second_waits_and_reads(pair):
    first, second = pair
    assert first.load_overload("f8", None) is None
    found = []
    other = threading.Thread(target=lambda: found.append(second.load_overload("f8", None)))
    other.start()
    other.join(0.1)
    assert other.is_alive()
    first.save_overload("f8", "code")
    other.join(10.0)
    assert found == ["code"]
    # neither has kept the claim
    assert second.load_overload("f4", None) is None
    second.save_overload("f4", "more")
    assert first.load_overload("f4", None) == "more"


def test_signatures_are_claimed_apart(pair):
    """Variants of one kernel are compiled beside each other; both are kept."""
    first, second = pair
    assert first.load_overload("f8", None) is None
    assert second.load_overload("f4", None) is None
    second.save_overload("f4", "more")
    first.save_overload("f8", "code")
    assert [cache.load_overload(word, None) for cache in pair for word in ("f4", "f8")] == [
        "more",
        "code",
    ] * 2


def test_patience_ends(pair, monkeypatch):
    monkeypatch.setattr(claims, "PATIENCE", 0.05)
    first, second = pair
    assert first.load_overload("f8", None) is None
    assert second.load_overload("f8", None) is None
    first.save_overload("f8", "code")
    second.save_overload("f8", "code")


def test_without_a_place_for_claims(tmp_path):
    cache = ClaimedCache(Disk(), tmp_path / "missing" / "kernel.claim")
    assert cache.load_overload("f8", None) is None
    cache.save_overload("f8", "code")
    assert cache.load_overload("f8", None) == "code"
