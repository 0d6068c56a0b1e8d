"""Formulas in Unicode, as the headers have them, as TeX for Doxygen: H_pm H_mm⁻¹ becomes H_{pm} H_{mm}^{-1}.

Indented lines become TeX whole; in a sentence only letters with an index do: all else reads well as it is typed.
"""

import re

RAISED = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻ᵀ", [*"0123456789+-", r"\top "]))
LOWERED = dict(zip("₀₁₂₃₄₅₆₇₈₉", "0123456789"))
ACCENTS = {"\u0302": r"\hat", "\u0303": r"\tilde", "\u0307": r"\dot", "\u0304": r"\bar", "\u0308": r"\ddot"}
SIGNS = {"½": r"{\tfrac12}", "¼": r"{\tfrac14}", "Σ": r"\sum ", "‖": r"\|", "⊞": r"\boxplus ", "⊟": r"\boxminus ", "⊗": r"\otimes ",
         "∘": r"\circ ", "×": r"\times ", "·": r"\cdot ", "−": "-", "≤": r"\le ", "≥": r"\ge ", "≠": r"\ne ", "≈": r"\approx ",
         "∝": r"\propto ", "→": r"\to ", "←": r"\leftarrow ", "↦": r"\mapsto ", "∂": r"\partial ", "√": r"\surd ", "∈": r"\in ",
         "…": r"\ldots ", "±": r"\pm ", "∞": r"\infty ", "ẋ": r"\dot x", "ḟ": r"\dot f", "δ": r"\delta ", "Δ": r"\Delta ", "{": r"\{", "}": r"\}",
         "%": r"\%", "#": r"\#", "&": r"\&", "§": r"\S "}
FUNCTIONS = "Exp|Log|vec|cos|sin|cot|exp|log|diag|min|max|argmin|wrap|rank|cov|Cov"
LETTER = "[A-Za-z\u0391-\u03c9]"
BELOW = "[A-Za-z0-9\u03b1-\u03c9]"
TOKEN = re.compile(
    rf"(?P<function>(?<![A-Za-z])(?:{FUNCTIONS})(?![A-Za-z]))|(?P<covariance>Σ(?=_[a-z]{{2}}(?![a-z])))"
    rf"|(?P<code>[A-Za-z]{{3,}}_\w+)|(?P<braced>_{{[^}}]*}})"
    rf"|(?P<word> ?(?<![A-Za-z_])(?!(?:{FUNCTIONS})(?![A-Za-z]))(?:[A-Za-z][A-Za-z-]{{2,}}(?:'s)?|an|as|at|by|if|in|is|it|of|on|or|so|to)(?![A-Za-z_]) ?)"
    rf"|(?P<accented>{LETTER})(?P<accent>[{''.join(ACCENTS)}])|(?P<low>_(?:[\u03b1-\u03c9][a-z]?|[A-Za-z0-9]{BELOW}*(?:_[A-Z][a-z]?)*(?:,[ij])?))|(?P<half>\^-?½)"
    rf"|(?P<raised>[{''.join(RAISED)}]+)|(?P<lowered>[{''.join(LOWERED)}]+)|(?P<sign>[{re.escape(''.join(SIGNS))}])|(?P<gap> {{2,}})", re.S)

# In a sentence: a letter with an index, such as H_ll⁻¹ or δb_a …
TERM = (rf"(?<![^\Wᵀ¹²])[dδΔ∂]?{LETTER}[{''.join(ACCENTS)}]?_(?:[\u03b1-\u03c9][a-z]?|[A-Za-z0-9]{{1,3}}(?:_[A-Z][a-z]?)*(?:,[ij])?(?![A-Za-z0-9_]))"
        rf"[{''.join(RAISED)}]*")
# … unless it is in code, or is a name that Doxygen reads.
KEPT = r"`[^`]*`|\"[^\"\s]*\"|\\f\$.*?\\f\$|@param\s+\w+(?:, \w+)*|@\w+(?: [\w./:]+)?|https?://\S+|\S*::\S*"
DRAWN = re.compile(r"[│┌└├┤┐┘─►#]|//|[;{}]\s*$|::|\b(?:const|template|class|public)\b")


def tex(formula: str) -> str:
    """The TeX of a formula; words in it stay words."""
    def one(token):
        kind, found = token.lastgroup, token[0]
        if kind == "accent":
            return rf"{ACCENTS[token['accent']]}{{{token['accented']}}}"
        return {"function": lambda: rf"\mathrm{{{found}}}", "covariance": lambda: r"\Sigma ", "word": lambda: rf"\text{{{found}}}",
                "code": lambda: r"\mathtt{" + found.replace("_", r"\_") + "}", "braced": lambda: "_{" + tex(found[2:-1]) + "}",
                "low": lambda: f"_{{{found[1:].replace('_', '')}}}", "half": lambda: f"^{{{found[1:-1]}" + r"\tfrac12}",
                "raised": lambda: "^{" + "".join(map(RAISED.get, found)) + "}",
                "lowered": lambda: "_{" + "".join(map(LOWERED.get, found)) + "}",
                "sign": lambda: SIGNS[found], "gap": lambda: r"\quad "}[kind]()
    return TOKEN.sub(one, formula)


def set_line(words: str) -> str:
    """A line of prose, its letters with an index between Doxygen's signs."""
    return re.sub(f"({KEPT})|({TERM})", lambda found: found[1] or rf"\f${tex(found[2])}\f$", words)


def set_block(block: str) -> str:
    """An indented block, set line by line if all of it is formulas; else a drawing, which keeps its look."""
    lines = [line for line in re.findall(r"///(.*)", block) if line.strip()]
    if any(map(DRAWN.search, lines)) or not all(re.search(r"[=≈←↦]", line) for line in lines):
        return block.replace("///   ", "///       ")
    return re.sub(r"///   +(.*)", lambda line: rf"/// \f[{tex(line[1])}\f]", block)
