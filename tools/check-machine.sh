#!/bin/sh
# Names what this machine lacks to build graincal, with the line that installs it (Debian and Ubuntu).
python=${1:-python3}
missing=""
command -v g++ >/dev/null 2>&1 || missing="$missing g++"
if ! command -v "$python" >/dev/null 2>&1; then
    missing="$missing python3 python3-venv python3-dev"
elif ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then
    echo "graincal needs Python 3.11 or newer, and $python is $("$python" -V 2>&1 | cut -d' ' -f2): name a newer one with 'make PYTHON=python3.12 ...'." >&2
    exit 1
else
    "$python" -c 'import ensurepip, venv' 2>/dev/null || missing="$missing python3-venv"
    "$python" -c 'import os, sys, sysconfig; sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' \
        || missing="$missing python3-dev"
fi
if [ -n "$missing" ]; then
    echo "This machine lacks$missing: install with 'apt-get install$missing' (as root, or with sudo) and run make again." >&2
    exit 1
fi
