#!/bin/sh
# Bundle what report.html uses of three.js and uPlot, with their licences, into the package. Needs node and npm; run
# it after a version in package.json has changed, and commit what it writes.
set -eu
cd "$(dirname "$0")"
npm ci --ignore-scripts
assets=../../src/supple/report/assets
{
  for library in three uplot; do
    printf '/* %s %s\n\n' "$library" "$(node -p "require('./node_modules/$library/package.json').version")"
    cat "node_modules/$library/LICENSE"
    printf '*/\n'
  done
  npx esbuild libraries.js --bundle --minify --format=iife --global-name=Libraries --target=es2021 \
    --legal-comments=none --log-level=warning
} > "$assets/libraries.js"
cp node_modules/uplot/dist/uPlot.min.css "$assets/libraries.css"
