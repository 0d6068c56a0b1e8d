"""What pages and figures say, in the reader's language.

words/en.json and words/zh.json have the same keys, the sentences of pages; {names} in braces stand for what a script fills
in. What stands inside a figure is its own key: words/figures.zh.json has it in Chinese.
"""
import json
import re
from pathlib import Path

PAGES = {"en": "report.html", "zh": "report.zh.html"}  # a language's page
NAMES = {"en": "English", "zh": "中文"}
SENTENCES = {language: json.loads((Path(__file__).parent / "words" / f"{language}.json").read_text(encoding="utf-8"))
             for language in PAGES}
IN_CHINESE = json.loads((Path(__file__).parent / "words" / "figures.zh.json").read_text(encoding="utf-8"))


UNITS = re.compile(r"(?<=\d) (?=(?:[cm]?m|m?s|rad|%)(?![A-Za-z])|× \d)|(?<=\d ×) (?=\d)")


class Words:
    """say(key, name=value, …) is the sentence of that key, in which no line breaks between a number and its unit."""

    def __init__(self, language):
        self.language = language

    def __call__(self, key, **values):
        sentence = SENTENCES[self.language][key]
        if "{{" in sentence:
            from .queries import fill  # Jinja2, which a fresh machine lacks
            sentence = fill(sentence, values)
        return UNITS.sub("\u00a0", sentence.format(**values))


class Labels:
    """say("prior weight w") is what stands in a figure; what has no Chinese, such as a name, is the same in both languages.
    `names` says how a word of the tables reads."""

    def __init__(self, language, names=None):
        self.language, self.names = language, names or {}

    def __call__(self, label, **values):
        english = self.names.get(label, label)
        return (IN_CHINESE.get(english, english) if self.language == "zh" else english).format(**values)
