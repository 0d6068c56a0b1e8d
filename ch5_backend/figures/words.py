"""What the pages say, in the reader's language.

words.json has every sentence in both languages, side by side; {names} in braces stand for what a script fills in. The words
inside the figures are English in both.
"""
import json
from pathlib import Path

PAGES = {"en": "report.html", "zh": "report.zh.html"}  # a language's page
NAMES = {"en": "English", "zh": "中文"}
SENTENCES = json.loads(Path(__file__).with_name("words.json").read_text(encoding="utf-8"))


class Words:
    """say(key, name=value, …) is the sentence of that key."""

    def __init__(self, language):
        self.language = language

    def __call__(self, key, **values):
        return SENTENCES[key][self.language].format(**values)
