"""Mutants of the solutions, made by machine: one line of a graded region each, changed as slips change it.

An id, "problem.cc:53:index:2", names the file, the line, the operator and which of its changes on this line. A rule has
a pattern and what may stand in its place; names and corners are exchanged within a family.
"""

import re
from dataclasses import dataclass

from ch5_backend.course.homework.regions import regions, solution_text, stage_of

NEXT = {" + ": [" - "], " - ": [" + "], " * ": [" / "], "++": ["--"],
        " += ": [" -= ", " = "], " -= ": [" += ", " = "], " = ": [" += "],
        " < ": [" <= ", " > "], " <= ": [" < "], " > ": [" >= ", " < "], " >= ": [" > ", " <= "],
        " == ": [" != "], " != ": [" == "], " && ": [" || "], " || ": [" && "], "!": [""],
        "continue": ["break"], "break": ["continue"]}
NUMBERS = {"0": ["1"], "1": ["0", "2"], "2": ["1", "3"], "3": ["2"], "6": ["3"], "0.0": ["1.0"], "1.0": ["2.0", "0.5"],
           "2.5": ["5.0", "1.25"], "5.0": ["10.0", "2.5"], "kEps": ["1e2 * kEps", "1e-2 * kEps"]}
MATRICES = r"hessian|tempH|tempB|temp_\w+|block|motion|covariance|axes|VtU_inverse|[A-Z]\w*"
CONDITION = r"\bif \((?P<condition>(?:[^()]|\((?:[^()]|\([^()]*\))*\))*)\)"

# Operator, pattern, what may stand instead of the match or of its group "here": a table, or templates.
RULES = [
    ("arithmetic", r" [+*-] ", NEXT),
    ("arithmetic", r"\+\+(?=\w)", NEXT),
    ("assignment", r" [+-]= ", NEXT),
    ("assignment", r"^ *(?!const |auto |for |if )\S[^=]*(?P<here> = )(?!\{)", NEXT),
    ("comparison", r" (?:[<>]=?|[=!]=) ", NEXT),
    ("logic", r" (?:&&|\|\|) |!(?=\w)", NEXT),
    ("logic", r"\bif \((?P<here>\w[\w\[\].>-]*(?:\(\))?)\)", [r"!\g<here>"]),
    ("condition", CONDITION, ["if (true)"]),
    ("condition", CONDITION + r"(?= \{)", ["if (false)"]),
    ("sign", r"(?<=[=(] )-(?=\w)|(?<=\()-(?=\w)", [""]),
    ("sign", r" = (?P<here>(?P<value>(?![^;]*->)[^-;{}=?&][^;{}=?&]*);$)", [r"-(\g<value>);"]),
    ("transpose", r"\.transpose\(\)", [""]),
    ("transpose", rf"(?<![\w.:&>])(?:{MATRICES})\b(?![](.:<>*&]| \w| [+-]?=)", [r"\g<0>.transpose()"]),
    ("constant", r"(?<![\w.])(?:\d(?:\.\d)?|kEps)(?![\w.])", NUMBERS),
    ("jump", r"\b(?:continue|break)\b", NEXT),
    ("statement", r"^ *(?!const |auto |for |VecX |MatXX |Mat33 |Vec3 |return )\S.*;$", [";"]),
    ("factor", r"\.(?:asDiagonal\(\) \* \w+|cwiseSqrt\(\)|inverse\(\)|conjugate\(\))", [""]),
    ("factor", r"\w[\w.]*(?:\([^()]*\))* \* (?=\w)", [""]),
    ("factor", r" \* \w[\w.]*(?:\([^()]*\))*", [""]),
]

BARE = r"(?<![\w.])"
INDEX = (r"(?:\w*(?:idx|index|size|dim)\w*|[ijklmn]2?_?|tail|position|\w\.number|\w+\.(?:rows|cols)\(\)|Pose\w+\(\w\))"
         r"(?: \+ \w+)?")
CORNERS = [family.split() for family in (
    ".topLeft .topRight .bottomLeft .bottomRight", ".head .tail", ".front .back", ".begin .end", ".leftCols .rightCols",
    ".rows .cols", ".setIdentity .setZero", ".norm .squaredNorm", ".x .y .z")]
NAMES = {
    "problem.cc": [
        "index_i index_j", "dim_i dim_j", "i j", "index_i dim_i", "index_j dim_j", "reserve_size marg_size",
        "Hmm Hpm Hmp", "bpp bmm", "tempH Hpm", "Hmm_inv Hmm", "delta_x_pp bpp", "temp_rows temp_botRows",
        "temp_b temp_botb", "temp_cols temp_rightCols", "dim tail_size idx", "n2 m2", "Arm Amr Arr",
        "tempB Arm Amm_inv", "W_rho Wr"],
    "gauge_prior.cc": ["i 0", "prior_weight pixel_information", "poses landmarks", ".p .q"],
    "gauge_freedom.cc": ["U V VtU_inverse", "Q motion T", "transformed covariance", "R axes", "p v"],
    "marginalization_error.cc": [
        "idx tail dim", "V W V_inv_sqrt", "W M", "b_a b_b", "p p_inverse", "S_sqrt S_pinv_sqrt", "e0_ b0_", "H H_",
        "b0 b0_", "J_ J_pinv_T"],
    "vins_window.cc": [
        "m_ n_", "idx_i idx_j", "size_i size_j", "idx_i size_i", "i j", "J_i block", "A_rm A_mr A_mm_pinv", "S S_pinv",
        "leaving next", "->b_a ->b_g", "kOld kSecondNew", "shifted->second block.vertex", ".q .p",
        "linearized_jacobians_ linearized_residuals_", "W_rho edge.Information()"],
    "block_solver.cc": [
        "i j", "i l", "a c", "H_pp_ H_pl_ H_ll_", "S_ H_pp_", "b_ b_schur_", "K_il H_ll_inverse_", "b_l rest",
        "PoseRow PoseDimension", ".number .is_landmark", "J_a JtW", "Wr b_"],
}


@dataclass(frozen=True)
class Mutant:
    file: str
    line: int      # in the solution
    operator: str
    number: int    # from 1
    text: str      # of the line, changed
    todo: str

    @property
    def id(self) -> str:
        return f"{self.file}:{self.line}:{self.operator}:{self.number}"

    @property
    def stage(self) -> dict:
        return stage_of(self.todo)

    def source(self) -> bytes:
        """The whole file, with this line in place of the solution's."""
        lines = solution_text(self.file).splitlines(keepends=True)
        lines[self.line - 1] = self.text + "\n"
        return "".join(lines).encode()


def by_rules(line: str):
    """(operator, changed line) of RULES."""
    for operator, pattern, instead in RULES:
        for match in re.finditer(pattern, line):
            here = "here" if "here" in match.groupdict() else 0
            for text in instead.get(match[here], []) if isinstance(instead, dict) else map(match.expand, instead):
                yield operator, line[:match.start(here)] + text + line[match.end(here):]


def by_families(line: str, families: list, operator: str):
    """Each word that belongs to a family, replaced by each other of it."""
    for family in families:
        words = (("" if word[0] in ".-" else BARE) + re.escape(word) + r"(?!\w)" for word in family)
        for match in re.finditer("|".join(words), line):
            for word in family:
                if operator == "corner" or not declares(line, match):
                    yield operator, line[:match.start()] + word + line[match.end():]


def known(word: str, scope: set) -> bool:
    """Whether this function may use the name: a member, a function, or what it has mentioned."""
    return not re.fullmatch(r"[A-Za-z]\w*[A-Za-z0-9]|[A-Za-z]", word) or word.startswith("Pose") or word in scope


def declares(line: str, match) -> bool:
    return bool(re.search(r"(?:const int|size_t|int|MatXX|VecX|auto|\[id,) $", line[:match.start()]))


def arguments(line: str) -> list:
    """The places of the arguments of each call, and of each index: [[(begin, end), …], …]."""
    calls, open_ones = [], []
    for k, letter in enumerate(line):
        if letter in "([{":
            call = k > 0 and (line[k - 1].isalnum() or line[k - 1] in "_>") and letter != "{"
            open_ones.append((call, [k + 1]))
        elif letter == "," and open_ones:
            open_ones[-1][1].append(k + 1)
        elif letter in ")]}" and open_ones:
            call, starts = open_ones.pop()
            ends = [start - 1 for start in starts[1:]] + [k]
            places = [(start + (line[start] == " "), end) for start, end in zip(starts, ends)]
            calls += [places] if call and all(begin < end for begin, end in places) else []
    return calls


def by_arguments(line: str):
    """Arguments exchanged, or one too many or too few."""
    for places in arguments(line):
        for k, (begin, end) in enumerate(places):
            for other_begin, other_end in places[k + 1:]:
                yield "arguments", "".join([line[:begin], line[other_begin:other_end], line[end:other_begin],
                                            line[begin:end], line[other_end:]])
            if re.fullmatch(INDEX, line[begin:end]):
                yield "index", line[:end] + " + 1" + line[end:]
    for match in re.finditer(r"(?:size_t|int) \w = (\w)(?=;)", line):
        for step in (" + 1", " - 1"):
            yield "index", line[:match.end(1)] + step + line[match.end(1):]


def mutants_of(file: str) -> list:
    """The mutants of a file's regions: one of each operator on each line, another one from line to line."""
    text, found = solution_text(file), []
    for region in regions(text):
        first = text[:text.index(region.solution)].count("\n") + 1
        for number, line in enumerate(region.solution.splitlines(), first):
            code, comment = re.fullmatch(r"(.*?)( *//.*)?", line).groups(default="")
            for operator, texts in changes(file, code, in_scope(text, number)).items():
                turn = number % len(texts)
                found.append(Mutant(file, number, operator, turn + 1, texts[turn] + comment, region.todo))
    return found


def in_scope(text: str, number: int) -> set:
    """The words of the function that the line belongs to, as far as the line."""
    before = "\n".join(text.splitlines()[:number])
    return set(re.findall(r"\w+", re.sub(" *//.*", "", before[before.rfind("\n}\n") + 1:])))


def changes(file: str, code: str, scope: set) -> dict:
    """{operator: the changed lines}, no two alike."""
    found = {code: None}
    names = [[word for word in family.split() if known(word, scope)] for family in NAMES[file]]
    for operator, changed in (*by_rules(code), *by_families(code, CORNERS, "corner"), *by_families(code, names, "name"),
                              *by_arguments(code)):
        found.setdefault(changed, operator)
    return {operator: [text for text, own in found.items() if own == operator]
            for operator in dict.fromkeys(found.values()) if operator}


def all_mutants() -> list:
    return [mutant for file in NAMES for mutant in mutants_of(file)]  # the open tasks earn no points


if __name__ == "__main__":
    for one in all_mutants():
        print(f"{one.id:45} {one.text.strip()}")
