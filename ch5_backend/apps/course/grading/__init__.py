"""./course grade: marks for submissions that nobody trusts."""

import sys

from ..build import ROOT

sys.path.insert(0, str(ROOT / "ch5_backend" / "apps" / "plot"))  # has what writes pages, and whole files
