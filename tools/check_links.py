"""Check the links of a built site: every page, picture and anchor inside it exists, every other address is well formed.

    python tools/check_links.py site

Nothing is fetched. What is wrong is printed page by page, and the exit code is 1.
"""

from __future__ import annotations

import argparse
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

__all__ = ["broken_links", "is_well_formed", "main"]

FOREIGN = ("http", "https", "mailto")


class _Page(HTMLParser):
    """Collects what a page offers to link to, and what it links to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("id", "name") and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


def is_well_formed(address: str) -> bool:
    """Whether an address outside the site can be one at all."""
    parts = urlsplit(address)
    if parts.scheme == "mailto":
        return "@" in parts.path
    return parts.scheme in FOREIGN and "." in parts.netloc and not any(c.isspace() for c in address)


def broken_links(site: Path) -> list[str]:
    """What is wrong with the links of a site, a line each."""
    pages = {path.resolve(): _Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    if not pages:
        return [f"{site} holds no pages"]
    found = []
    for path, page in pages.items():
        if path.name == "404.html":  # its links count from the root of a server
            continue
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme == "data":
                continue
            if parts.scheme or parts.netloc:
                reason = "" if is_well_formed(link) else "is not well formed"
            else:
                target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
                target = target / "index.html" if target.is_dir() else target
                reason = "" if target.exists() else "leads nowhere"
                anchor = unquote(parts.fragment)
                if not reason and anchor and target in pages and anchor not in pages[target].anchors | {"__top"}:
                    reason = "names an anchor that is not there"
            if reason:
                found.append(f"{path.relative_to(site.resolve())}: {link} {reason}")
    return sorted(set(found))


def main(arguments: list[str] | None = None) -> int:
    """Check a folder; the exit code is 1 where a link is broken."""
    parser = argparse.ArgumentParser(description="Check the links of a built site.")
    parser.add_argument("site", type=Path)
    site = parser.parse_args(arguments).site
    found = broken_links(site)
    print("\n".join(found) if found else f"{site}: all links hold")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
