#!/bin/sh
# Bundle the parts of three.js and uPlot used by report.html, with their licences, into the package. Needs node and
# npm. Run this after a change of a version in package.json, and commit the written files.
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
