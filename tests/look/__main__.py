"""python3 -m tests.look accept [WORD…]: what the last Look.look has seen is right, of the views whose names have all words."""

import json
import sys

from tests.look.look_test import LOOKED
from tests.look.views import accept

if sys.argv[1:2] != ["accept"]:
    sys.exit(__doc__)
names = accept(json.loads((LOOKED / "seen.json").read_text(encoding="utf-8")), sys.argv[2:])
print(f"{len(names)} views accepted")
sys.exit(0 if names else 2)
