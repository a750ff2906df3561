"""Every example of a docstring and of docs/reference/python.md runs; the stubs name all that there is."""

import ast
import doctest
import json
import pathlib
import pydoc
import re

import pytest

import msd

ROOT = pathlib.Path(__file__).parents[3]


def documented():
    yield "msd", msd.__doc__
    for name in msd.__all__:
        thing = getattr(msd, name)
        if isinstance(thing, (str, list)):
            continue
        yield name, thing.__doc__
        if isinstance(thing, type) and not issubclass(thing, Exception):
            for member, value in vars(thing).items():
                if not member.startswith("_"):
                    yield f"{name}.{member}", value.__doc__


@pytest.mark.parametrize("name, text", list(documented()))
def test_examples_run(name, text, tmp_path, monkeypatch):
    monkeypatch.setenv("MSD_CACHE", str(tmp_path))
    assert text, f"{name} has no docstring"
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, 0)
    flags = doctest.IGNORE_EXCEPTION_DETAIL * 0 | doctest.ELLIPSIS
    assert doctest.DocTestRunner(optionflags=flags, verbose=False).run(test).failed == 0


@pytest.mark.parametrize("page", ["docs/reference/python.md", "crates/msd-py/README.md"])
def test_snippets_of_a_page_run(page):
    for snippet in re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.S):
        exec(snippet, {})


@pytest.mark.parametrize("path", sorted((ROOT / "examples/python").glob("*.ipynb")))
def test_notebooks_run(path, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib", reason="SKIPPED notebooks: pip install matplotlib").use("Agg")
    monkeypatch.setenv("MSD_CACHE", str(tmp_path))
    notebook = json.loads(path.read_text())
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    names = {}
    for cell in cells:
        exec(cell, names)
    lines = names["plt"].gca().get_lines()
    assert {line.get_label() for line in lines if len(line.get_xdata())} >= {"rk4", "xpbd"}


def test_help_names_open_and_the_keys_of_scenes():
    text = pydoc.plain(pydoc.render_doc(msd))
    assert "open(name, keys=None)" in text
    assert not any("docs/reference" in (text or "") for _, text in documented())


def test_the_stubs_name_what_there_is():
    tree = ast.parse((pathlib.Path(msd.__file__).parent / "__init__.pyi").read_text())

    def names(body):
        for row in body:
            if isinstance(row, (ast.ClassDef, ast.FunctionDef)):
                yield row.name
            elif isinstance(row, ast.AnnAssign):
                yield row.target.id

    assert set(msd.__all__) == {name for name in names(tree.body) if name[0] != "_"} | {"__version__"}
    for row in tree.body:
        thing = getattr(msd, row.name, None) if isinstance(row, ast.ClassDef) else None
        if thing and not issubclass(thing, Exception):
            there = {name for name in vars(thing) if name[0] != "_"}
            assert there == {name for name in names(row.body) if name[0] != "_"}
