"""The Python cells of a page run in their order, as in a notebook, and print what the page shows."""

import ast
import contextlib
import io
import os
import re
import warnings

import pages
from support import TestCase


def run_cell(fence, namespace):
    """What a notebook shows below a cell: what is printed, and the value of the last expression."""
    printed = io.StringIO()
    tree = ast.parse(fence.text)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(printed), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        exec(compile(tree, fence.place, "exec"), namespace)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), fence.place, "eval"), namespace)
            if value is not None:
                print(repr(value))
    return printed.getvalue() + "".join(f"{warning.category.__name__}: {warning.message}\n" for warning in caught)


def loose(text):
    """Numbers may differ in their digits, as in tests/docs/examples.py."""
    return re.sub(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?", "0", " ".join(text.split()))


class Pages(TestCase):
    def test_cells(self):
        self.addCleanup(os.chdir, os.getcwd())
        cells = sum(self.run_page(page) for page in pages.pages())
        self.assertGreater(cells, 8)

    def run_page(self, page):
        """The number of cells, which ran in a folder of their own."""
        cells = [fence for fence in pages.fences(page) if fence.language == "python" and "no-run" not in fence.options]
        if cells:
            (self.folder / page.stem).mkdir()
            os.chdir(self.folder / page.stem)
        namespace, shown = {}, ""
        for fence in pages.fences(page):
            if fence in cells:
                with self.subTest(fence.place):
                    shown = run_cell(fence, namespace)
            elif "result" in fence.options:
                pattern = re.escape(loose(fence.text)).replace("…", ".*")
                self.assertRegex(loose(shown), f"^{pattern}$", fence.place)
        return len(cells)
