"""The reading edition: a deck as a text that is read alone, on a code host, in an editor or on the site.

Every page of the deck is a section of one Markdown file, its numbers and code filled in, its figure beside it, and below it
what the lecturer says. Where the page asks, that is folded away, since it answers.
"""

import re

WORDS = {"en": ("Lecture {n} of chapter 5, to read: every page with its figure and, in the indented lines, what the lecturer says. "
                "[The homework]({home})", "What the lecturer says"),
         "zh": ("第五章第 {n} 讲的阅读版：每页配有插图，缩进部分是讲课时说的话。[作业]({home})", "讲课时说的话")}
HOME = {"en": "../../ch5_homework/README.md", "zh": "../../ch5_homework/README.zh.md"}
NOTE = re.compile(r"<!-- \(\d+ min\) (.*?) -->", re.S)
FIGURE = re.compile(r"!\[[^\]]*\]\(figures/(\w+)\.svg\)")
LAB = re.compile(r"\[([^\]]*)\]\(\.\./(?:lab|report)\.html[^)]*\)")  # these are built; where the text is read they may not be


def reading(name, lang, text, titles):
    """The Markdown of the deck `name`, whose filled-in `text` is without the marks of its pages; {figure: what it shows}."""
    _, _, text = text.partition("\n---\n")  # the head of the file
    about, summary = WORDS[lang]
    pages = [page(one.strip(), lang, summary, titles) for one in re.split(r"^---$", text, flags=re.M)]
    title, _, rest = pages[0].partition("\n")
    head = f"{title}\n\n{about.format(n=name[0], home=HOME[lang])}\n{rest}"
    return "\n\n".join([head, *pages[1:]]) + "\n"


def page(text, lang, summary, titles):
    asks = re.search(r"^<!-- _class: [\w ]*\bask\b", text, re.M)
    note = NOTE.search(text)[1]
    said = f"<details><summary>{summary}</summary>\n\n{note}\n\n</details>" if asks else "> " + note
    text = re.sub(r"<!--.*?-->\n*", "", text, flags=re.S).strip()
    text = FIGURE.sub(lambda found: f"![{titles[found[1]]}](figures/{found[1]}.{lang}.svg)", LAB.sub(r"\1", text))
    return f"{text}\n\n{said}"
