#!/usr/bin/env bash
# Gradescope runs this once, for the image: installs what is needed and builds what does not depend on a submission.
set -e
cd "${AUTOGRADER:-/autograder}/source"
./course grade --prepare
