"""Words of messages."""

from viscorod.wording import with_article


def test_articles_go_by_the_first_letter():
    assert [with_article(noun) for noun in ("identification", "free decay")] == [
        "an identification",
        "a free decay",
    ]
