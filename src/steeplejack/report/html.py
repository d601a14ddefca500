"""Pieces of a page. Text is escaped here and nowhere else: everything that comes in as ``str`` is text, not markup."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files

POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""Of the page's content."""


class Markup(str):
    """Finished HTML, taken over as it stands."""

    __slots__ = ()


def text(value: object) -> Markup:
    """Markup as it is, anything else escaped."""
    return value if isinstance(value, Markup) else Markup(escape(str(value), quote=True))


def join(parts: Iterable[object], by: str = "") -> Markup:
    """Parts one after the other."""
    return Markup(by.join(text(part) for part in parts))


def element(name: str, *parts: object, cls: str = "") -> Markup:
    """An element with its content."""
    mark = f' class="{escape(cls, quote=True)}"' if cls else ""
    return Markup(f"<{name}{mark}>{join(parts)}</{name}>")


def document(title: str, body: Markup, style: str = "") -> str:
    """A whole page that fetches nothing: styles stand in it, pictures are data."""
    styles = files("steeplejack.report").joinpath("page.css").read_text(encoding="utf-8") + style
    head = join(
        (
            Markup('<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'),
            Markup(f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'),
            element("title", title),
            element("style", Markup(styles)),
        )
    )
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n{body}</html>\n'


def section(title: str, *parts: object) -> Markup:
    """A section with its heading."""
    return element("section", element("h2", title), *parts)


def figure(drawing: Markup, title: str, caption: object) -> Markup:
    """A drawing that scrolls sideways where the screen is narrow, with its caption."""
    frame = Markup(f'<div class="drawing" role="img" aria-label="{escape(title, quote=True)}">{drawing}</div>')
    return element("figure", frame, element("figcaption", element("b", title, ". "), caption))


def table(
    head: Sequence[object], rows: Iterable[Sequence[object]], numeric: Iterable[int] = (), cls: str = ""
) -> Markup:
    """A table that scrolls sideways where the screen is narrow; ``numeric`` columns are set to the right."""
    right = set(numeric)

    def line(cells: Sequence[object], name: str) -> Markup:
        return element("tr", *(element(name, cell, cls="n" if i in right else "") for i, cell in enumerate(cells)))

    body = element("tbody", *(line(row, "td") for row in rows))
    return element("div", element("table", element("thead", line(head, "th")), body, cls=cls), cls="table")


def terms(pairs: Iterable[tuple[object, object]]) -> Markup:
    """A list of names and values."""
    return element("dl", *(element("div", element("dt", name), element("dd", value)) for name, value in pairs))


def bullets(items: Iterable[object]) -> Markup:
    """A list."""
    return element("ul", *(element("li", item) for item in items))


def folded(title: str, *parts: object) -> Markup:
    """Content that opens on request."""
    return element("details", element("summary", title), *parts)


def badge(word: str, kind: str) -> Markup:
    """A word on a coloured ground: good, warn, bad or plain."""
    return element("span", word, cls=f"badge {kind}")
