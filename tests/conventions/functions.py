"""Finds the functions of a C++ or a Python source and counts their lines of code.

A line of code holds more than blanks, comments and, in Python, a documentation string. A function's lines go from the one
with its opening brace, or from its `def`, to its last; lambdas and local classes belong to the function around them.
"""

import ast
import io
import re
import tokenize
from dataclasses import dataclass


@dataclass(frozen=True)
class Function:
    name: str
    line: int        # where it begins, from 1
    code_lines: int


def functions_of(suffix: str, text: str) -> list:
    """The functions of a source file, `suffix` being ".h", ".cc" or ".py"."""
    return python_functions(text) if suffix == ".py" else cpp_functions(text)


# Raw strings first: they may hold anything. A quote between digits only separates them (1'000'000).
_NOT_CODE = re.compile(r'R"(?P<mark>[^ ()\\\n]*)\(.*?\)(?P=mark)"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"'
                       r"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'|^[ \t]*#(?:\\\n|[^\n])*", re.DOTALL | re.MULTILINE)


def _only_code(text: str) -> str:
    """The C++ text without comments; strings and preprocessor lines keep their lines, but hold only x."""
    def replacement(match):
        found = match[0]
        fill = " " if found.startswith(("//", "/*")) else "#" if found.lstrip().startswith("#") else "x"
        return re.sub(r"[^\n]", fill, found)
    return _NOT_CODE.sub(replacement, text)


def cpp_functions(text: str) -> list:
    """The functions that are defined at namespace or class level. Raises ValueError where the braces do not match."""
    lines = _only_code(text).split("\n")
    return [Function(function_name(part.head), part.first, sum(1 for line in lines[part.first - 1:part.last] if line.strip(" #\t")))
            for part in declarations(text) if part.kind == "function"]


@dataclass(frozen=True)
class Declaration:
    kind: str       # "namespace", "type", "function" or "other"
    head: str       # what stands before its brace or semicolon
    first: int      # the line of its opening brace or semicolon
    last: int       # the line of its end; of namespaces and types `first` again
    in_class: bool


def declarations(text: str) -> list:
    """What stands at namespace and class level in a C++ text, by matching braces; not what functions hold.

    Raises ValueError where the braces do not match.
    """
    code, found = _only_code(text), []
    scopes = []          # the kinds of the open braces
    begin, line = 0, 1   # where the present declaration began, and the line that we are in
    inside = None        # (kind, head, line) of the function or initialiser around us
    parentheses = 0
    for position, sign in enumerate(code):
        line += sign == "\n"
        parentheses += {"(": 1, ")": -1}.get(sign, 0) if inside is None else 0
        in_class = "type" in scopes
        if sign == "{":
            scopes.append("other" if inside or parentheses else _kind(code[begin:position]))
            if inside or parentheses:
                continue
            if scopes[-1] == "function":
                inside = ("function", code[begin:position], line, len(scopes))
            elif scopes[-1] != "other":
                found.append(Declaration(scopes[-1], code[begin:position], line, line, in_class))
                begin = position + 1
        elif sign == "}":
            if not scopes:
                raise ValueError(f"line {line}: a closing brace without an opening one")
            if inside and inside[3] == len(scopes):
                found.append(Declaration("function", inside[1], inside[2], line, in_class))
                inside = None
            if scopes.pop() != "other":
                begin = position + 1
        elif sign == ";" and not (inside or parentheses or "other" in scopes):
            found.append(Declaration("other", code[begin:position], line, line, in_class))
            begin = position + 1
    if scopes:
        raise ValueError(f"{len(scopes)} braces are never closed")
    return found


def _kind(head: str) -> str:
    """What a brace opens after the words `head` at namespace or class level."""
    head = _without_templates(re.sub(r"#+|\b(?:public|protected|private)\s*:(?!:)", " ", head)).strip()
    if re.match(r"(?:inline\s+)?namespace\b|extern\s+x+$", head):
        return "namespace"
    if re.match(r"(?:typedef\s+)?(?:class|struct|union|enum)\b", head):
        return "type"
    if head.endswith(("=", ",", "(", "return")) or "(" not in head:
        return "other"
    initialisers = re.search(r"\)[\s\w]*:(?!:)(.*)$", head, re.DOTALL)  # of a constructor: its body follows ) or }
    if initialisers and not initialisers[1].rstrip().endswith((")", "}")):
        return "other"
    return "function"


def _without_templates(head: str) -> str:
    """Drops a leading template<…>, whose own words (class, typename) say nothing about what follows."""
    while match := re.match(r"\s*template\s*<", head):
        depth, parentheses, end = 1, 0, match.end()
        while depth and end < len(head):
            parentheses += {"(": 1, ")": -1}.get(head[end], 0)
            depth += {"<": 1, ">": -1}.get(head[end], 0) if parentheses == 0 else 0
            end += 1
        head = head[end:]
    return head


def function_name(head: str) -> str:
    """The word before the first parenthesis; TEST(Suite, Claim) by its claim."""
    head = _without_templates(re.sub(r"#+", " ", head))
    if match := re.search(r"\b(?:TYPED_)?TEST(?:_F|_P)?\(([^)]*)\)", head):
        return re.sub(r"\s*,\s*", ".", match[1].strip())
    match = re.search(r"(operator\s*(?:\(\)|[^\s(]+)|[\w:~]+)\s*\(", head)
    return match[1] if match else head.split("\n")[-1].strip()


def python_functions(text: str) -> list:
    """Functions and methods, also those inside of others."""
    code = _python_code_lines(text)
    return [Function(node.name, node.lineno, len(code & set(range(node.lineno, node.end_lineno + 1))))
            for node in ast.walk(ast.parse(text)) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]


def _python_code_lines(text: str) -> set:
    """The numbers of the lines that hold code."""
    skipped = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    lines = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in skipped:
            lines |= set(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(text)):  # a documentation string is an expression of its own
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines -= set(range(node.lineno, node.end_lineno + 1))
    return lines
