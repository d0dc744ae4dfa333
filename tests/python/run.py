"""Runs the tests of the Python module. ctest gives the package's folder and the program; exit code 77: skipped."""

import argparse
import os
import pathlib
import sys
import unittest

FOLDER = pathlib.Path(__file__).resolve().parent


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--package", help="the folder that contains the package tactus; left out: it was not built")
    parser.add_argument("--program", help="the program, whose results are compared")
    parser.add_argument("tests", nargs="*", help="names of tests, such as test_render; default: all")
    options = parser.parse_args()
    if options.package is None:
        print("SKIPPED: the Python module was not built: it needs pybind11 and the headers of Python")
        return 77
    try:
        import numpy  # noqa: F401
    except ImportError:
        print("SKIPPED: numpy is not installed for", sys.executable)
        return 77
    sys.path[:0] = [options.package, str(FOLDER), str(FOLDER.parent / "docs")]
    sys.dont_write_bytecode = True
    os.environ["TACTUS_PROGRAM"] = str(pathlib.Path(options.program).resolve())
    loader = unittest.TestLoader()
    tests = loader.loadTestsFromNames(options.tests) if options.tests else loader.discover(FOLDER, "test_*.py")
    return 0 if unittest.TextTestRunner(verbosity=2).run(tests).wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
