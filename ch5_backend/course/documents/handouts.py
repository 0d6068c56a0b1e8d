"""The homework's pages, the lectures to read and the guide as web pages: Markdown as GitHub reads it, in the style of the reports."""

import posixpath
import re
from urllib.parse import unquote

from markupsafe import Markup, escape

from ch5_backend.figures import page

from ..base.anchors import anchor
from ..base.cmake_build import ROOT
from ..base.errors import CourseError

try:
    from markdown_it import MarkdownIt
    from markdown_it.token import Token
except ImportError:
    raise CourseError("the site needs markdown-it for Python; Debian and Ubuntu: apt-get install python3-markdown-it") from None

HOMEWORK = {f"ch5_homework/README{end}.md": f"homework/index{end}.html" for end in ("", ".zh")}
FIGURES = {"slides/figures": "figures", "slides/reading/figures": "lectures/figures"}
GUIDE = {f"ch5_backend/{source}{end}.md": f"{place}{end}.html" for end in ("", ".zh")
         for source, place in (("GUIDE", "guide"), ("MAP", "map"), ("experiments/README", "measured"), ("experiments/EVIDENCE", "evidence"))}
STYLE = Markup("""
article pre { white-space: pre; overflow-x: auto; line-height: 1.3; font-size: .8rem; }
article pre code { padding: 0; background: none; }
article table { display: block; overflow-x: auto; width: max-content; max-width: 100%; }
article th, article td { text-align: left; white-space: normal; min-width: 4.5rem; }
article img { max-width: 100%; background: #fff; border-radius: .5rem; }
article details { border-left: 3px solid var(--line); padding-left: .9rem; margin: .6rem 0; }
article mjx-container[display="true"] { overflow-x: auto; overflow-y: hidden; }
article summary { cursor: pointer; font-weight: 600; }
""")
MATH = re.compile(r"\$\$.+?\$\$|\$(?:\\.|[^$\\])+\$", re.S)
MATH_WITH_MARKS = re.compile(f"(?:{MATH.pattern})[，。；：、！？）.,;:!?)]*", re.S)
MATHJAX = Markup("""<script>MathJax = {{tex: {{inlineMath: [["$", "$"]]}}}}</script>
<script defer src="{}"></script>""")
SUBSCRIPT = re.compile(r"(?<!\w)([A-Za-zΑ-Ωα-ω])_([A-Za-z0-9]{1,3})(?![A-Za-z0-9_])")


def sources() -> dict:
    """{Markdown file: its page on the site}, of what students and engineers read."""
    handout = {f"ch5_homework/handout/{path.name}": f"homework/{path.stem}.html"
               for path in sorted((ROOT / "ch5_homework" / "handout").glob("*.md"))}
    lectures = {f"slides/reading/{path.name}": f"lectures/{path.stem}.html" for path in sorted((ROOT / "slides" / "reading").glob("*.md"))}
    return {**HOMEWORK, **handout, **GUIDE, **lectures}


class Links:
    """Where the links of the project's pages lead on a site that has the files `there`."""

    def __init__(self, there: set):
        self.there = there
        self.places = {**sources(), "README.md": "index.html", "README.zh.md": "index.html", "ch5_backend/README.md": "api/index.html", "lab.html": "lab.html"}
        for folder, place in FIGURES.items():
            self.places |= {f"{folder}/{path.name}": f"{place}/{path.name}" for path in (ROOT / folder).glob("*.svg")}

    def follow(self, source: str, link: str) -> str:
        """The link of a page, as it reads on the site, or "" if the site has not what it leads to."""
        if re.match(r"\w+:", link) or link.startswith("#"):
            return link
        file, _, fragment = unquote(link).partition("#")
        target = posixpath.normpath(posixpath.join(posixpath.dirname(source), file))
        place = self.places.get(target)
        if place not in self.there:
            return ""
        found = posixpath.relpath(place, posixpath.dirname(self.places[source]) or ".")
        return found + (f"#{fragment}" if fragment and place != "index.html" else "")  # the front page has not the README's sections


def write_pages(site, links: Links) -> None:
    """All of them, each into its place on the site."""
    for source, place in sources().items():
        text = (ROOT / source).read_text(encoding="utf-8")
        (site / place).parent.mkdir(exist_ok=True)
        title = re.search(r"^# (.*)$", text, re.MULTILINE)[1].replace("`", "")
        up = posixpath.relpath("index.html", posixpath.dirname(place) or ".")
        mathjax = "api/mathjax/MathJax.js"  # without the API, formulas stay as they are typed
        formulas = posixpath.relpath(mathjax, posixpath.dirname(place) or ".") if MATH.search(text) and (site / mathjax).exists() else ""
        language = "zh" if source.endswith(".zh.md") else "en"
        words = {"en": "Chapter 5", "zh": "第五章"}[language]
        page.write(site / place, title, [Markup("<style>{}</style>{}\n<p><a href=\"{}#{}\">{}</a></p>\n<article>{}</article>").format(
            STYLE, MATHJAX.format(formulas) if formulas else "", up, language, words, render(text, source, links))], language)


def render(text: str, source: str, links: Links) -> Markup:
    """The body of one page. What a picture shows stays as it is typed; in sentences H_pp is set with a subscript."""
    reader = MarkdownIt("commonmark", {"html": True}).enable("table")
    reader.inline.ruler.before("escape", "math", keep_math)
    tokens = reader.parse(re.sub(r"(?<=[，。：；、！？（“]) (?=\$)", "", text))  # a code host needs the blank, Chinese has none there
    for heading, inline in zip(tokens, tokens[1:]):
        if heading.type == "heading_open":
            heading.attrSet("id", anchor(re.sub(r"`", "", inline.content)))
    for token in tokens:
        if token.type == "inline":
            token.children = [new for child in token.children for new in set_words(child)]
            follow_links(token.children, source, links)
    html = reader.renderer.render(tokens, reader.options, {})
    return Markup(html.replace("<th></th>", "<td></td>").replace("<pre>", '<pre tabindex="0">').replace("<table>", '<table tabindex="0">'))


def keep_math(state, silent: bool) -> bool:
    """A formula between dollars stays as it is typed, for MathJax: nothing in it is emphasis or a link, and no line begins with
    the punctuation behind it."""
    if found := MATH_WITH_MARKS.match(state.src, state.pos):
        state.pos = found.end()
        if not silent:
            state.push("html_inline", "", 0).content = f'<span style="white-space: nowrap">{escape(found[0])}</span>'
    return bool(found)


def set_words(token: Token) -> list:
    """A piece of a sentence, in which single letters with an index are set as in a book."""
    if token.type != "text" or not SUBSCRIPT.search(token.content):
        return [token]
    html = SUBSCRIPT.sub(r"<i>\1</i><sub>\2</sub>", str(escape(token.content)))
    return [Token("html_inline", "", 0, content=html)]


def follow_links(children: list, source: str, links: Links) -> None:
    """Each leads to where its target is on the site; where that has none, the words stay."""
    dead = 0
    for token in children:
        if token.type == "image":
            token.attrSet("src", links.follow(source, token.attrGet("src")) or token.attrGet("src"))
        elif token.type == "link_open":
            found = links.follow(source, token.attrGet("href"))
            token.attrSet("href", found)
            if not found:
                token.hidden, dead = True, dead + 1
                token.type, token.tag, token.content, token.attrs = "text", "", "", {}
        elif token.type == "code_inline" and token.content.startswith("lab.html#"):
            found = links.follow(source, posixpath.relpath(token.content, posixpath.dirname(source)))
            if found:
                language = "zh" if source.endswith(".zh.md") else "en"
                token.type, token.content = "html_inline", f'<a href="{escape(found)}&amp;lang={language}"><code>{escape(token.content)}</code></a>'
        elif token.type == "link_close" and dead:
            dead -= 1
            token.type, token.tag, token.content = "text", "", ""
