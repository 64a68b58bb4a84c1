#!/usr/bin/env python3
"""Builds the package kmech over a built library: build.py --include DIR --library DIR --to DIR --installed DIR [--compiler CC]

Writes DIR/kmech with the modules of this folder, the docstrings of the public headers, and cffi's module, which the
compiler checks against the headers."""
import argparse
import os
import shutil
import sys
from pathlib import Path

from cffi import FFI

import declarations

HERE = Path(__file__).resolve().parent
OWN = """
typedef struct kmech_watch { void *handle; double last; } kmech_watch;
static km_progress kmech_progress_function(void);
extern "Python" bool kmech_python_progress(void *context, double done);
extern "Python" bool kmech_python_forces(void *context, const km_motion_sample *sample, double *joint_forces, double (*wrenches)[6]);
"""


def read_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--include", action="append", required=True)
    parser.add_argument("--library", required=True)
    parser.add_argument("--to", required=True)
    parser.add_argument("--compiler", default="cc")
    parser.add_argument("--installed", required=True, help="the library's folder, seen from the package's, after installation")
    return parser.parse_args()


def copy_modules(package):
    package.mkdir(parents=True, exist_ok=True)
    for old in package.glob("*.py"):
        old.unlink()
    for source in [*HERE.glob("kmech/*.py"), HERE / "kmech/py.typed"]:
        shutil.copy(source, package)


def write_comments(package, folders):
    headers = [header for folder in folders for header in Path(folder, "kmech").glob("*.h")]
    texts = declarations.comments(headers)
    modules = declarations.module_comments(headers)
    (package / "_comments.py").write_text(
        '"""The comments of the public headers: written by build.py."""\n'
        f"FUNCTIONS = {texts!r}\nHEADERS = {modules!r}\n", encoding="utf-8")


def searched(library, package, installed):
    """Where the library lies, seen from the package: in the build folder, then in an installation."""
    return ["$ORIGIN/" + os.path.relpath(library, package), "$ORIGIN/" + installed]


def compile_module(options, package):
    ffi = FFI()
    ffi.cdef(declarations.declarations(options.compiler, options.include) + OWN)
    library = str(Path(options.library).resolve())
    ffi.set_source("kmech._kmech", (HERE / "progress.c").read_text(), include_dirs=options.include, libraries=["kmech"],
                   library_dirs=[library], runtime_library_dirs=searched(library, package, options.installed),
                   extra_compile_args=["-O2", "-w", "-g0"])
    os.environ["CC"] = options.compiler
    ffi.compile(tmpdir=str(package.parent), verbose=False)
    for left in [package / "_kmech.c", *package.glob("*.o")]:
        left.unlink(missing_ok=True)


def main():
    options = read_arguments()
    options.include = [str(Path(folder).resolve()) for folder in options.include]
    package = Path(options.to).resolve() / "kmech"
    copy_modules(package)
    write_comments(package, options.include)
    compile_module(options, package)
    return 0


if __name__ == "__main__":
    sys.exit(main())
