#!/bin/sh
# Names what this machine lacks to build graincal, with the line that installs it (Debian and Ubuntu).
python=${1:-python3}
missing=""
command -v "${CXX:-g++}" >/dev/null 2>&1 || missing="$missing g++"
if ! command -v "$python" >/dev/null 2>&1; then
    if [ "$python" != python3 ]; then
        echo "There is no $python on this machine: name another with 'make PYTHON=... '." >&2
        exit 1
    fi
    missing="$missing python3 python3-venv python3-dev"
elif ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then
    echo "graincal needs Python 3.11 or newer, and $python is $("$python" -V 2>&1 | cut -d' ' -f2): name a newer one with 'make PYTHON=python3.12 ...'." >&2
    exit 1
else
    # Debian names the packages of its own Python python3-..., those of another version after it.
    package=python3
    [ "$python" = python3 ] || package=$("$python" -c 'import sys; print("python%d.%d" % sys.version_info[:2])')
    "$python" -c 'import ensurepip, venv' 2>/dev/null || missing="$missing $package-venv"
    "$python" -c 'import os, sys, sysconfig; sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' \
        || missing="$missing $package-dev"
fi
if [ -n "$missing" ]; then
    echo "This machine lacks$missing: install with 'apt-get install$missing' (as root, or with sudo) and run make again." >&2
    exit 1
fi
