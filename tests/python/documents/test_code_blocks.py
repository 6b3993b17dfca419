"""Python and shell blocks of the Markdown pages run as pasted, or the page says why not."""

import shutil

import pytest
from code_blocks import LANGUAGES, PAGES, ROOT, Session, blocks, difference

RUN = [
    page for page in PAGES if any(b.language in {"python", "sh"} for b in blocks(page.read_text()))
]


def of(page):
    return page.relative_to(ROOT).as_posix()


def run(page, tmp_path, monkeypatch, *, nightly):
    monkeypatch.chdir(tmp_path)
    session = Session(tmp_path)
    for block in blocks(page.read_text()):
        if "mpirun" in block.code and shutil.which("mpirun") is None:
            continue
        if block.remark in ("", "output") or (block.remark == "runs nightly" and nightly):
            session.run(block, page)


@pytest.mark.parametrize("page", PAGES, ids=of)
def test_every_code_block_names_its_language(page):
    assert {block.language for block in blocks(page.read_text())} <= LANGUAGES


@pytest.mark.parametrize("page", RUN, ids=of)
def test_the_code_blocks_of_a_page_run_as_pasted(page, tmp_path, monkeypatch):
    run(page, tmp_path, monkeypatch, nightly=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [page for page in RUN if any(b.remark == "runs nightly" for b in blocks(page.read_text()))],
    ids=of,
)
def test_the_long_code_blocks_of_a_page_run_as_pasted(page, tmp_path, monkeypatch):
    run(page, tmp_path, monkeypatch, nightly=True)


def test_a_block_is_saved_run_or_left_out_as_the_text_before_it_says(tmp_path):
    page = (
        "Save this as `mine.py`:\n\n```python\nx = 1\n```\n\n"
        "<!-- not run: needs a cluster -->\n\n```sh\nfalse\n```\n\n"
        "```{fields} Cloth\n```\n\n```sh\ntest -f mine.py\n```\n"
    )
    saved, left_out, last = blocks(page)
    assert (saved.file, saved.line, saved.remark) == ("mine.py", 4, "")
    assert (left_out.remark, left_out.reason) == ("not run", "needs a cluster")
    session = Session(tmp_path)
    session.run(saved, ROOT / "README.md")
    session.run(last, ROOT / "README.md")
    with pytest.raises(AssertionError, match=r"README\.md, line 10"):
        session.run(left_out, ROOT / "README.md")


def test_the_output_that_a_page_shows_is_that_of_the_preceding_block(tmp_path):
    page = "```python\nprint('3 cloths')\n```\n\n<!-- output -->\n\n```text\n{}\n```\n"
    for shown, stale in (("3 cloths", False), ("4 cloths", True), ("3 cloths\nend", True)):
        code, output = blocks(page.format(shown))
        assert output.remark == "output"
        directory = tmp_path / shown.replace("\n", "-")
        directory.mkdir()
        session = Session(directory)
        session.run(code, ROOT / "README.md")
        if stale:
            with pytest.raises(AssertionError, match=r"README\.md, line 8: the page shows"):
                session.run(output, ROOT / "README.md")
        else:
            session.run(output, ROOT / "README.md")


@pytest.mark.parametrize(
    ("shown", "printed", "equal"),
    [
        ("stretch 1.04\n", "stretch 1.05\n", True),
        ("stretch 1.04\n", "stretch 1.24\n", False),
        ("stretch 1.04\n", "strain 1.04\n", False),
        ("0 pairs\n", "1 pairs\n", False),
        ("shift 0.1 mm\n", "shift 0.2 mm\n", True),
        ("energy -3.0e-05 J\n", "energy -3.1e-05 J\n", True),
        ("energy -3.0e-05 J\n", "energy 3.0e-05 J\n", False),
        ("from .../ball.py\n", "from /tmp/4/ball.py\n", True),
        ("one\n", "one\ntwo 2\n", False),
        ("one\ntwo\n", "one\n", False),
    ],
)
def test_shown_and_printed_output_agree_in_words_and_nearly_in_numbers(shown, printed, equal):
    assert (difference(shown, printed) == "") is equal
