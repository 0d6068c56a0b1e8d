"""An answer is computed by lines of C++: a file that brings machine code, or reads other files than the headers, is refused.

Not by a search in its text, which macros, line splices and escapes deceive: by what a compiler has made of it, before
anything of it is assembled or linked. Clang's is its intermediate code, GCC's the preprocessed text.
"""

import posixpath
import re

# Of intermediate code. A text in it, or a name, has no quote, and may be long. A template that is empty, or one line that the
# assembler takes for a comment, as in Eigen's kernels, holds no code.
TEXTS = re.compile(r'(?:\bc|(?<=[@%$!]))"[^"\n]*"')
IN_IR = re.compile(r'^module (asm) |\b(asm) (?:[a-z]+ )*"(?!#[^"\\\n]*")[^"\n]|^@.*, (section) "(?!llvm\.metadata")|^@[^=\n]* = .*\b(ifunc) |"\w+-(section)"=', re.MULTILINE)
# Of preprocessed text: a literal, in which no word counts, or a word. One without an end, which does not compile, ends with the
# line or the text, so that no quote in it is tried as a beginning. A label without spaces, as libc's headers give their
# functions, holds no code.
WORD = re.compile(r'(?:u8|[uUL])?R"([^()\\\s]{0,16})\(.*?(?:\)\1"|\Z)|(?:u8|[uUL])?"(?:\\.|[^"\\\n])*"?|\d(?:\'?[\w.])*|\'(?:\\.|[^\'\\\n])*\'?|^[ \t]*#[^\n]*|\w+', re.DOTALL | re.MULTILINE)
# A constant of 64 bits stands in the code that loads it, into which a program may jump: a hundred of them are a program.
LONG = {True: re.compile(r" i64 -?\d{11,}"), False: re.compile(r"\b(?:0[xX][\da-fA-F']{9,}|\d[\d']{10,})(?=[uUlL]*\b)")}  # in IR or not
MOST_LONG = 100
ASM = {"asm", "__asm", "__asm__"}
PLACED = {"section", "__section__", "ifunc", "__ifunc__", "alias", "__alias__", "symver", "__symver__"}
LABEL = re.compile(r'\s*\(\s*(?:"[\w.$]*"\s*)+\)')
ATTRIBUTE = re.compile(r'\s*\(\s*"')
HEADERS = ("/usr/include/", "/usr/lib/", "/usr/local/include/", "/submission/")


def foreign_code(code: str, is_ir: bool, usual=frozenset()) -> str:
    """The word by which it has come in, such as "asm", or ""; `usual` is what the course's own headers have of it."""
    if len({*LONG[is_ir].findall(code)} - usual) > MOST_LONG:
        return "constants"
    if is_ir:
        found = IN_IR.search(TEXTS.sub("", "\n".join(lines_with(("asm", "section", "ifunc"), code))))
        return next(filter(None, found.groups())) if found else ""
    return next((word for word, text in statements(code) if text not in usual), "")


def lines_with(words: tuple, code: str):
    """Those lines of a long text in which one of the words stands: patterns take a hundred times as long for all of it."""
    for word in words:
        at = code.find(word)
        while at >= 0:
            end = code.find("\n", at) % (len(code) + 1)
            yield code[code.rfind("\n", 0, at) + 1:end]
            at = code.find(word, end)


def usual_code(code: str) -> frozenset:
    """What the headers alone have, as `usual` above."""
    return frozenset([*(text for _, text in statements(code)), *LONG[False].findall(code)])


def statements(code: str):
    """(word, its brackets) of all that may place machine code in a preprocessed text."""
    for found in WORD.finditer(code):
        word, rest = found[0], code[found.end():found.end() + 2000]
        if word in ASM and not LABEL.match(rest) or word in PLACED and ATTRIBUTE.match(rest):
            yield word, re.sub(r"\s+", "", rest.partition(";")[0])


def foreign_file(rule: str, own: tuple) -> str:
    """The first file that a compiler has read, by its rule for make, which is neither a header of the system nor below `own`."""
    escaped = filter(None, re.split(r"(?<!\\)\s+", rule.replace("\\\n", " ").partition(": ")[2]))
    words = [re.sub(r"\\([ #])", r"\1", word).replace("$$", "$") for word in escaped]  # as make reads them
    return next((word for word in words if not posixpath.normpath(word).startswith((*HEADERS, *own))), "")


# The text between brackets, quotes or comment signs: a student's lines that open none around a blank, and steer no
# preprocessor, cannot read what is written there.
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\d(?:\'?[\w.])*|\'(?:\\.|[^\'\\\n])*\'|\w+|\S', re.DOTALL)
STEERS = re.compile(r'\\\s*\n|\?\?/|%:|\bR"|\b(?:_Pragma|__pragma)\b')
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:<[\w./+-]+>|"ch5_[\w./]+")[ \t]*(?://[^\n]*)?$', re.MULTILINE)


def closed_to(text: str, places: list) -> bool:
    """Whether what is written at these places, offsets into a student's text, is out of reach of the lines around."""
    # As long as before, so that places stay. A carriage return alone ends a line, too, and with it a comment.
    text = text.replace("\r\n", " \n").replace("\r", "\n")
    text, open_, places = INCLUDE.sub(lambda found: " " * len(found[0]), text), [], sorted(places, reverse=True)
    if STEERS.search(text):
        return False
    for found in TOKEN.finditer(text):
        while places and places[-1] <= found.start():
            if places.pop() and any(one != "{" for one in open_):
                return False
        if places and places[-1] < found.end():  # in the midst of a comment
            return False
        word = found[0]
        if word in ("#", '"', "'") or text.startswith("/*", found.start()) and len(word) < 4:
            return False
        if word in ("(", "[", "{"):
            open_.append(word)
        elif word in (")", "]", "}") and (not open_ or "([{".index(open_.pop()) != ")]}".index(word)):
            return False
    return not places or all(one == "{" for one in open_)
