"""What pages and figures say, in the reader's language.

words/en.json and words/zh.json have the same keys; {names} in braces stand for what a script fills in. The keys of the
decks begin with their topic, TOPICS. The words inside the report's figures are drawn in English, and
translate.py turns them by figures.zh.json.
"""
import json
from pathlib import Path

PAGES = {"en": "report.html", "zh": "report.zh.html"}  # a language's page
NAMES = {"en": "English", "zh": "中文"}
TOPICS = ("backend.", "solvers.", "windows.", "gauge.", "speed.", "certainty.")
SENTENCES = {language: json.loads((Path(__file__).parent / "words" / f"{language}.json").read_text(encoding="utf-8"))
             for language in PAGES}


class Words:
    """say(key, name=value, …) is the sentence of that key; `prefix`, such as "gauge.", stands before every key."""

    def __init__(self, language, prefix=""):
        self.language, self.prefix = language, prefix

    def __call__(self, key, **values):
        return SENTENCES[self.language][self.prefix + key].format(**values)
