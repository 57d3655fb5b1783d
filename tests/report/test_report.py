"""The report as a file: what it says, and that it needs nothing besides itself."""

import re
import shutil
import subprocess
from html.parser import HTMLParser

import pytest

from graincal.campaign import FolderError
from graincal.report import summarise, write_report

from .test_figures import RESULTS

FRAME = """<iframe src="report.html" width="WIDTH" height="900" style="border: 0"></iframe>
<script>
  const frame = document.querySelector("iframe");
  frame.addEventListener("load", () => setTimeout(() => {
    const page = frame.contentDocument;
    const plots = [...page.querySelectorAll(".plot")];
    const drawn = plots.filter((plot) => plot.querySelector(".main-svg"));
    const overflowing = drawn.filter((plot) => plot.scrollWidth > plot.clientWidth);
    const sideways = [...page.querySelectorAll(".scrolls")].filter((each) => each.scrollWidth > each.clientWidth);
    page.querySelectorAll("details").forEach((each) => (each.open = true));
    const { clientWidth, scrollWidth } = page.documentElement;
    document.body.dataset.seen = [plots.length, drawn.length, overflowing.length, sideways.length, clientWidth, scrollWidth].join(" ");
  }, 500));
</script>"""
LOOK = """<iframe src="report.html" width="WIDTH" height="900" style="border: 0"></iframe>
<script>
  // Contrast as WCAG 2 defines it.
  const light = (rgb) => rgb.map((part) => part / 255).map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4)).reduce((sum, part, k) => sum + part * [0.2126, 0.7152, 0.0722][k], 0);
  const numbers = (colour) => (colour.match(/[\\d.]+/g) || []).map(Number);
  const frame = document.querySelector("iframe");
  frame.addEventListener("load", () => setTimeout(() => {
    const page = frame.contentDocument, view = frame.contentWindow;
    page.querySelectorAll("details").forEach((each) => (each.open = true));
    const behind = (element) => {
      for (let each = element; each; each = each.parentElement) {
        const colour = numbers(view.getComputedStyle(each).backgroundColor);
        if (colour.length === 3 || colour[3] === 1) return colour.slice(0, 3);
      }
      return [255, 255, 255];
    };
    const pale = [], seen = [];
    for (const element of page.querySelectorAll("main *")) {
      if (![...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim())) continue;
      if (element.closest("style, script, noscript, .hoverlayer")) continue;
      const style = view.getComputedStyle(element), ink = light(numbers(element.closest("svg") ? style.fill : style.color).slice(0, 3)), ground = light(behind(element));
      const contrast = (Math.max(ink, ground) + 0.05) / (Math.min(ink, ground) + 0.05);
      seen.push(contrast);
      if (contrast < 4.5) pale.push(`${element.tagName} ${contrast.toFixed(1)}`);
    }
    const levels = [...page.querySelectorAll("h1, h2, h3, h4, h5, h6")].map((each) => each.tagName[1]).join("");
    document.body.dataset.seen = [seen.length, levels, pale.join(", ")].join("|");
  }, 500));
</script>"""
LOADING = {"src", "href", "srcset", "data", "poster", "action"}


class Reader(HTMLParser):
    """Collects the text outside scripts, what would be loaded, and tags that are not closed."""

    def __init__(self):
        super().__init__()
        self.text, self.loaded, self.open, self.headings = [], [], [], []

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta", "link", "br", "path", "circle", "rect"):
            self.open.append(tag)
        self.loaded += [value for name, value in attributes if name in LOADING and not value.startswith("data:,")]

    def handle_endtag(self, tag):
        if tag not in ("path", "circle", "rect"):
            assert self.open.pop() == tag

    def handle_data(self, data):
        if not {"script", "style"} & set(self.open):
            self.text.append(data)
            if self.open and self.open[-1] == "h2":
                self.headings.append(data)


def read(path):
    reader = Reader()
    reader.feed(path.read_text(encoding="utf-8"))
    assert reader.open == []
    return reader


@pytest.fixture
def page(result, tmp_path):
    return read(write_report(result, tmp_path / "report.html"))


@pytest.mark.parametrize("name", RESULTS)
def test_a_report_is_one_file_that_loads_nothing(name, request, tmp_path):
    path = write_report(request.getfixturevalue(name), tmp_path / "report.html")
    assert read(path).loaded == []
    text = path.read_text(encoding="utf-8")
    # Plotly's script once, and a browser that refuses whatever else.
    assert text.count("plotly.js v") == 1
    assert "default-src 'none'" in text
    assert "url(" not in re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)
    assert [each.name for each in tmp_path.glob("*report*")] == ["report.html"]


def test_the_sections_stand_in_the_order_of_a_reader(page):
    answer, table, *sections = page.headings
    assert answer.startswith("The most probable response is ") and table == "The most probable sample and its 90 % interval"
    assert sections == ["What was found", "Parameters", "Pairs", "Fabric", "Where the runs went", "Method", "Provenance"]


def test_it_says_first_what_was_found(result, page):
    text = "".join(page.text)
    assert summarise(result).splitlines()[0] in text.replace("\n", " ")
    assert re.search(r"φ is narrowed: [\d.]+ to [\d.]+ deg hold 90 % of the weight; the weighted samples are at 29\.\d ± 2\.\d deg\.", text)
    assert re.search(r"ηm is not identified: [\d.]+ to [\d.]+ hold 90 % of the weight\.", text)
    assert "Only 3 samples did so far, too few to outline a range" in text and not re.search("(?<!not |led )identified", text)
    assert result.grade.reasons[0] in text
    # Words are defined before they are used.
    body = text[text.index("What was found") :]
    assert body.index("most probable") == body.index("most probable sample is that of the largest weight")
    assert body.index("the best") == body.index("the best is that of the smallest error of all iterations")
    assert "Stopped after 3 iterations: the limit of 3 iterations is reached." in text
    assert "not on the noise of the measurement" in text
    assert "Up to a third is called narrowed" in text


def test_it_says_what_failed_and_where(result, page):
    text = "".join(page.text)
    assert f"{result.evaluations} samples evaluated, {result.failures} failed." in text
    assert "no <equilibrium> was found" in text
    assert "They stand apart from the other samples in φ (from " in text


def test_it_says_what_it_was_computed_with(result, page):
    text = "".join(page.text)
    for value in (*result.provenance.values(), result.calibration.method, "scale peak"):
        assert value in text


def test_a_running_campaign_is_called_so(running):
    assert "Not at its end: 3 iterations are complete" in summarise(running)


def test_without_weights_it_says_why(without_weights, all_failed):
    assert "There are no weights: only" in summarise(without_weights)
    assert "All 33 samples failed, so that nothing was found." in summarise(all_failed)


def test_a_file_that_cannot_be_written_is_named(result, tmp_path):
    (tmp_path / "report.html").mkdir()
    with pytest.raises(FolderError, match="report.html"):
        write_report(result, tmp_path / "report.html")
    assert [each.name for each in tmp_path.iterdir()] == ["report.html"]


def opened(frame, folder):
    """A page with the report in a frame, for a headless window cannot be as narrow as a telephone, as a browser leaves it."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("no Chromium is installed to open the report with")
    (folder / "frame.html").write_text(frame, encoding="utf-8")
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--v=0", "--virtual-time-budget=10000", "--dump-dom"]
    command += ["--allow-file-access-from-files", f"--user-data-dir={folder / 'profile'}", (folder / "frame.html").as_uri()]
    run = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    return run


@pytest.mark.parametrize("width", [1280, 390])
def test_text_stands_out_and_headings_step_down_one_by_one(width, two_experiments, tmp_path):
    write_report(two_experiments, tmp_path / "report.html")
    run = opened(LOOK.replace("WIDTH", str(width)), tmp_path)
    texts, levels, pale = re.search('data-seen="([^"]*)"', run.stdout)[1].split("|")
    # 4.5 is what WCAG's level AA asks of text.
    assert int(texts) > 100 and pale == ""
    assert levels[0] == "1" and levels.count("1") == 1
    assert all(int(below) <= int(above) + 1 for above, below in zip(levels, levels[1:]))


@pytest.mark.parametrize(("name", "width"), [("two_experiments", 1280), ("two_experiments", 390), ("strange_names", 390)])
def test_a_browser_draws_it_without_a_network_an_error_or_a_scroll_to_the_side(name, width, request, tmp_path):
    report = write_report(request.getfixturevalue(name), tmp_path / "report.html")
    run = opened(FRAME.replace("WIDTH", str(width)), tmp_path)
    # Errors of scripts, and what the page's policy kept from being loaded.
    assert "CONSOLE" not in run.stderr, run.stderr
    plots, drawn, overflowing, sideways, inside, content = map(int, re.search('data-seen="([^"]*)"', run.stdout)[1].split())
    assert drawn == plots == report.read_text(encoding="utf-8").count('class="plot"')
    assert overflowing == 0
    assert sideways == 0 or width < 1280
    assert content == inside
