"""Whose a submission is. In this order; the first that answers decides:

    1. the sheet's column submissions, which may give one submission to several;
    2. Gradescope's submission_metadata.yml beside it: its SIDs, addresses and names;
    3. the number that Moodle or Canvas writes into a name, then the person's name before it;
    4. an id as a word in the name of the submission, then in that of its folder;
    5. a student's full name, if it is there.

Letters are compared as a reader sees them: composed or not, in any case and width, without marks of direction. Between
a number and Chinese letters a word ends, and of a long number between it and any: 2021012345张三 has the id 2021012345. If there is an id and the name of another student,
or two ids, there is no guess: all of them may claim the submission, and it gives none of them a mark.
"""

import re
import unicodedata
from pathlib import Path

HAN_RANGES = (("\u3400", "\u9fff"), ("\uf900", "\ufaff"), ("\U00020000", "\U0003ffff"))
HAN = "".join(f"{first}-{last}" for first, last in HAN_RANGES)
MOODLE = re.compile(r"(?P<person>.*?)_(?P<number>\d+)_assignsubmission_(?:file|onlinetext)(?P<rest>_.*|$)", re.DOTALL)
CANVAS = re.compile(r"(?P<person>\w+?)_(?P<late>late_)?(?P<number>\d+)_(?P<attachment>\d+)_(?P<rest>.+)", re.DOTALL | re.IGNORECASE)


def folded(text: str) -> str:
    """As it is compared."""
    text = unicodedata.normalize("NFKC", text).casefold()
    text = "".join(str(unicodedata.decimal(letter)) if unicodedata.category(letter) == "Nd" else letter for letter in text
                   if unicodedata.category(letter) != "Cf")
    return unicodedata.normalize("NFC", text)


def squeezed(text: str) -> str:
    """A name without spaces and signs, as Canvas writes it."""
    return "".join(letter for letter in folded(text) if letter.isalnum())


def platform_name(text: str):
    """The parts of a name that Moodle or Canvas has made, or None."""
    return MOODLE.fullmatch(text) or CANVAS.fullmatch(text)


def has_word(text: str, word: str) -> bool:
    """Whether it stands there and does not go on; both folded. Chinese goes on in Chinese, a number of six digits or more in digits,
    all else in all else."""
    goes_on, at = in_digits if word.isdigit() and len(word) > 5 else in_letters, text.find(word)
    while at >= 0:
        before, after = text[at - 1:at], text[at + len(word):at + len(word) + 1]
        if not goes_on(before, word[0]) and not goes_on(word[-1], after):
            return True
        at = text.find(word, at + 1)
    return False


def in_digits(letter: str, following: str) -> bool:
    return letter.isdigit() and following.isdigit()


def in_letters(letter: str, following: str) -> bool:
    return letter.isalnum() and following.isalnum() and is_han(letter) == is_han(following)


def is_han(letter: str) -> bool:
    return any(first <= letter <= last for first, last in HAN_RANGES)


def names_in(text: str) -> set:
    """Each run of up to five words, squeezed: one of them may be somebody's name."""
    words = re.findall(f"[{HAN}]+|\\d+|[^\\W\\d_{HAN}]+", folded(text))
    return {"".join(words[k:k + n]) for k in range(len(words)) for n in range(1, 6)}


def owners_of(students: list, record: dict) -> list:
    """None, one, or those among whom only a human can decide; several too where the sheet gives it to them."""
    path = Path(record["path"])
    texts = [path.name, path.parent.name]
    calls = {folded(record["name"]), folded(path.name)}
    if named := [student for student in students if calls & set(map(folded, student.submissions))]:
        return named
    if submitters := record.get("submitters"):
        return [student for student in students
                if any(set(map(folded, filter(None, (one.get("sid"), one.get("email"))))) & student.keys or
                       squeezed(one.get("name", "")) in student.names for one in submitters)]
    for text in texts:
        if owners := match_platform(students, text):
            return owners
    for text in texts:
        if owners := match_words(students, words_of(students, text)):
            return owners
    return []


def match_platform(students: list, text: str) -> list:
    found = platform_name(text)
    if not found:
        return []
    platform = "moodle" if found.re is MOODLE else "canvas"
    known = any(platform in student.numbers for student in students)
    at_place = [student for student in students
                if (student.numbers.get(platform) if known else platform == "canvas" and student.id) == found["number"]]
    person = squeezed(found["person"])
    return at_place or [student for student in students if person and person in student.names]


def words_of(students: list, text: str) -> str:
    """What may tell the owner where the platform's number does not: nothing where the class's table has its numbers and none is
    this; else all but the number, which may be another student's id."""
    found = platform_name(text)
    if not found:
        return text
    if any(("moodle" if found.re is MOODLE else "canvas") in student.numbers for student in students):
        return ""
    return f"{found['person']} {found['rest']}" if found.re is MOODLE else text


def match_words(students: list, text: str) -> list:
    whole, names = folded(text), names_in(text)
    by_id = [student for student in students if any(has_word(whole, key) for key in student.keys)]
    by_name = [student for student in students if student.names & names]
    if by_id and any(student in by_name for student in by_id):
        by_name = [student for student in by_name if not any(student.names & one.names for one in by_id)]
    return by_id + [student for student in by_name if student not in by_id]


def look_alike(students: list, record: dict) -> str:
    """The id of a student whose zeros in front a spreadsheet has eaten: 00123 in the name of a submission, 123 in the sheet."""
    numbers = {number.lstrip("0") for number in re.findall(r"(?<!\d)0\d+", record["name"])} - {""}
    return next((student.id for student in students if student.id in numbers), "")
