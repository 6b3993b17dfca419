"""Comments and documents cite only works, equations, links, pictures and files that exist. Web
addresses are not checked.
"""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
REFERENCES = ROOT / "core" / "references.md"
# Matches keys such as [Author1984], and fdlibm, the only key without a year.
CITATION = re.compile(r"\[([A-Z][A-Za-z]+\d{2,4}[a-z]?|fdlibm)\]")
# Matches a path from the repository's root that is neither part of another path nor a pattern.
FOLDERS = "bindings|core|docs|python|renderer|scenes|scripts|tests"
PATH = re.compile(
    rf"(?<![\w./<*{{-])((?:{FOLDERS})/(?:[\w.-]+/)*[\w-]+(?:\.\w+)?/?)(?![\w*{{(\\<])"
)
# Files that name fragments of the changelog as examples. These fragments do not exist.
EXAMPLES = {"changes/README.md", "tests/python/architecture/test_release.py"}
DOCUMENT = re.compile(r"(?<![\w./-])([\w/.-]+\.md)\b")
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
BUILT = re.compile(r"build\S*/$")  # prefix of a path to a build product


def files(*suffixes: str) -> list[Path]:
    command = ["git", "ls-files", "-co", "--exclude-standard"]
    if not (ROOT / ".git").exists():
        pytest.skip("not a git checkout", allow_module_level=True)
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    found = [ROOT / line for line in done.stdout.splitlines() if "third_party" not in line]
    return sorted(p for p in found if p.suffix in suffixes and p.exists() and p != Path(__file__))


def texts() -> dict[str, str]:
    """Returns the text of each source and document, by its path from the repository's root."""
    paths = files(".cpp", ".h", ".py", ".md", ".txt", ".toml", "")
    return {p.relative_to(ROOT).as_posix(): p.read_text() for p in paths}


def entries() -> set[str]:
    return set(re.findall(r"^- \[(\w+)\]", REFERENCES.read_text(), re.M))


def test_every_cited_work_is_listed_and_every_listed_one_is_cited() -> None:
    cited: dict[str, str] = {}
    for name, text in texts().items():
        if name != "core/references.md":
            cited |= dict.fromkeys(CITATION.findall(text), name)
    unlisted = {key: name for key, name in cited.items() if key not in entries()}
    assert not unlisted, "cited, but not in core/references.md"
    assert not entries() - set(cited), "in core/references.md, but nowhere cited"


def test_no_work_is_listed_twice() -> None:
    titles = [t.lower() for t in re.findall(r"\*([^*]+)\*", REFERENCES.read_text())]
    flat = [re.sub(r"\s+", " ", title) for title in titles]
    assert sorted(set(flat)) == sorted(flat)


def anchors(path: Path) -> set[str]:
    """Returns the anchors that GitHub creates for the headings."""
    headings = re.findall(r"^#+ (.+)$", path.read_text(), re.M)
    plain = [re.sub(r"[^\w\s-]", "", heading).strip().lower() for heading in headings]
    return {heading.replace(" ", "-") for heading in plain}


@pytest.mark.parametrize("path", files(".md"), ids=lambda p: p.relative_to(ROOT).as_posix())
def test_links_and_pictures_of_a_document_exist(path: Path) -> None:
    for link in LINK.findall(path.read_text()):
        if re.match(r"\w+:", link):
            continue  # skips web addresses
        target, _, anchor = link.partition("#")
        found = (path.parent / target).resolve() if target else path
        assert found.exists(), link
        assert not anchor or anchor in anchors(found), link


def test_files_that_comments_and_documents_name_exist() -> None:
    absent = []
    for name, text in texts().items():
        if name.endswith("test_architecture.py"):
            continue  # contains patterns that look like paths
        for found in PATH.finditer(text):
            before = text[: found.start()].rsplit(None, 1)[-1] if found.start() else ""
            if not BUILT.search(before) and not (ROOT / found[1]).exists():
                absent.append(f"{name}: {found[1]}")
    assert not absent


def test_documents_that_are_named_exist() -> None:
    known = {path.name for path in files(".md")}
    absent = [
        f"{name}: {document}"
        for name, text in texts().items()
        if name not in EXAMPLES
        for document in DOCUMENT.findall(text)
        if document.rsplit("/", 1)[-1] not in known
    ]
    assert not absent


def test_the_equations_of_the_method_have_different_numbers_and_all_that_are_cited_exist() -> None:
    formulas = (ROOT / "docs" / "method.md").read_text().split("```")[1::2]
    numbers = [n for formula in formulas for n in re.findall(r"\((M\d+)\)", formula)]
    assert sorted(set(numbers)) == sorted(numbers)
    cited = {
        number: name for name, text in texts().items() for number in re.findall(r"\bM\d\d\b", text)
    }
    unknown = {number: name for number, name in cited.items() if number not in numbers}
    assert not unknown, "cited, but not an equation of docs/method.md"
