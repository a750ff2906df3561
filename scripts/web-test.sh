#!/usr/bin/env bash
# Drives the page of scripts/web.sh in Chromium and, where it is installed, in Firefox, through
# WebGPU and through WebGL2.
#
#   scripts/web-test.sh [FOLDER]           with pictures of what it saw in FOLDER
#   MSD_WEB_TEST=REGEX scripts/web-test.sh only the tests in Chromium whose names match
set -euo pipefail
cd "$(dirname "$0")/.."

for tool in node npm; do
    if ! command -v $tool >/dev/null; then
        echo "web-test: SKIPPED, no $tool (install it with: apt install nodejs npm)"
        [ -z "${MSD_REQUIRE_BROWSER:-}" ]
        exit
    fi
done
if [ ! -f web/dist/msd_bg.wasm ]; then
    echo "web-test: there is no page yet; scripts/web.sh builds it" >&2
    exit 2
fi
# One package without others, which brings no browser.
[ -d web/node_modules/playwright-core ] || npm --prefix web ci --no-audit --no-fund
# Neither may take for ever: a browser that hangs is a failure.
timeout 1800 node web/test.mjs "$@"
[ -n "${MSD_WEB_TEST:-}" ] || timeout 900 node web/firefox.mjs "$@"
