"""The documentation builds as a site, without a warning, and is read without a network."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

import graincal

pytest.importorskip("sphinx", reason="the site is built by Sphinx (pip install '.[docs]')")
DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "--keep-going",
        "--quiet",
        "--builder",
        "html",
        "--doctree-dir",
        folder / "doctrees",
        DOCS,
        folder / "html",
    ]
    built = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert built.returncode == 0, built.stderr
    return folder / "html"


class _Page(HTMLParser):
    """What a page fetches by itself (scripts, styles, pictures), where its links lead, and the names in it that links can lead to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.fetched, self.links, self.ids = [], [], set()
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes) -> None:
        given = dict(attributes)
        self.ids.add(given.get("id"))
        if tag == "a":
            self.links.append(given.get("href") or "")
        elif tag == "link" and given.get("rel") in ("stylesheet", "icon", "preload"):
            self.fetched.append(given["href"])
        elif "src" in given:
            self.fetched.append(given["src"])


@pytest.fixture(scope="module")
def pages(site) -> dict[Path, _Page]:
    return {path.resolve(): _Page(path) for path in site.rglob("*.html")}


def test_every_document_is_a_page(site):
    documents = [path.relative_to(DOCS) for path in DOCS.rglob("*.md") if "_build" not in path.parts]
    assert documents and not [name for name in documents if not (site / name).with_suffix(".html").exists()]


def test_pages_fetch_nothing_from_another_site(pages, site):
    fetched = [address for page in pages.values() for address in page.fetched]
    fetched += [address for style in site.rglob("*.css") for address in re.findall(r"(?:@import|url\()\s*[\"']?((?:https?:)?//[^\"')\s]+)", style.read_text())]
    assert [address for address in fetched if re.match(r"(https?:)?//", address)] == []


def test_internal_links_lead_somewhere(pages):
    broken = []
    for path, page in pages.items():
        for link in page.links:
            if re.match(r"[a-z]+:", link) or not link:
                continue
            address, _, name = link.partition("#")
            target = (path.parent / address).resolve() if address else path
            if not target.exists() or (name and target in pages and name not in pages[target].ids):
                broken.append(f"{path.name}: {link}")
    assert broken == []


def test_every_command_is_on_the_page_of_commands(site):
    from typer.main import get_command

    from graincal.cli import app

    text = re.sub(r"<[^>]+>", "", (site / "reference" / "commands.html").read_text())
    names = [f"graincal {name}" for name, command in get_command(app).commands.items() if not hasattr(command, "commands")]
    assert [name for name in names if name not in text] == []


def test_every_public_name_is_on_the_page_of_the_api(site):
    text = (site / "reference" / "api.html").read_text()
    assert [name for name in graincal.__all__ if f'id="graincal.{name}"' not in text] == []
