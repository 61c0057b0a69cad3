"""What the site has beside docs/: README as its first page, a page for each module, and files that pages link to."""

import os
import re
from pathlib import Path, PurePosixPath

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("forms", "analytic", "simulations")
PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "CONTRIBUTING.md", "CHANGELOG.md": "CHANGELOG.md"}
LINK = re.compile(r"\]\(([^)#:]+)(#[^)]*)?\)")


def on_files(files, config):
    """Add the pages that are not in docs/."""
    modules = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]
    listed = "# Interfaces\n\nOne page a module, from its docstrings.\n\n"
    for path in modules:
        name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        files.append(File.generated(config, f"api/{name}.md", content=f"::: {name.removesuffix('.__init__')}\n"))
        listed += f"- [{name.removesuffix('.__init__')}](api/{name}.md): {first_line(path)}\n"
    files.append(File.generated(config, "api.md", content=listed))
    for source, target in PAGES.items():
        files.append(File.generated(config, target, content=(ROOT / source).read_text(encoding="utf-8")))
    for page in [*(ROOT / name for name in PAGES), *(ROOT / "docs").glob("*.md")]:
        for target, _ in LINK.findall(page.read_text(encoding="utf-8")):
            path = (page.parent / target).resolve()
            kept = f"files/{path.relative_to(ROOT)}" if path.is_file() else ""
            if kept and in_site(path) == PurePosixPath(kept) and kept not in files.src_uris:
                files.append(File.generated(config, kept, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown, page, config, files):
    """Links as they are in the repository, turned to where their targets are in the site."""
    source = {target: name for name, target in PAGES.items()}.get(page.file.src_uri)
    folder = ROOT if source else (ROOT / "docs" / page.file.src_uri).parent
    if page.file.src_uri.startswith("api"):
        return markdown

    def turned(match):
        path = (folder / match[1]).resolve()
        place = in_site(path) if path.exists() else PurePosixPath(match[1])
        return f"]({os.path.relpath(place, PurePosixPath(page.file.src_uri).parent)}{match[2] or ''})"

    return LINK.sub(turned, markdown)


def in_site(path: Path) -> PurePosixPath:
    """Where a file of the repository is found in the site."""
    place = PurePosixPath(path.relative_to(ROOT).as_posix())
    if str(place) in PAGES:
        return PurePosixPath(PAGES[str(place)])
    if place.parts[0] == "docs":
        return PurePosixPath(*place.parts[1:])
    if place.suffix == ".py" and place.parts[0] in ROOMS:
        return PurePosixPath("api", ".".join(place.with_suffix("").parts) + ".md")
    return PurePosixPath("files") / place


def first_line(path: Path) -> str:
    """What a module says of itself."""
    text = path.read_text(encoding="utf-8")
    line = text[3:].partition('"""')[0].partition("\n")[0] if text.startswith('"""') else ""
    return re.sub(r"[*_`<>\[\]]", " ", line)
