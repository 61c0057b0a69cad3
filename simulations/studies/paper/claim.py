"""A sentence of the paper, our number for it, and whether it holds."""

import re
from dataclasses import dataclass

HOLDS, IN_PART, FAILS, UNCHECKED = "holds", "holds in part", "does not hold", "not checked"


@dataclass(frozen=True)
class Claim:
    """place: section or figure; sentence: what the paper says; found: our numbers in words."""

    place: str
    sentence: str
    found: str
    verdict: str

    def row(self) -> str:
        """A row of a Markdown table."""
        return minus_signs(f"| {self.place} | {self.sentence} | {self.found} | {self.verdict} |")


def minus_signs(text: str) -> str:
    """Hyphens in front of numbers as minus signs; those of exponents and of words stay."""
    return re.sub(r"(?<!\w)-(?=\d)", "−", text)


def table(claims: list[Claim]) -> str:
    """Markdown table of claims."""
    head = "| where | the paper says | we find | |\n|---|---|---|---|\n"
    return head + "".join(claim.row() + "\n" for claim in claims)


def verdict(whole: bool, partly: bool = False) -> str:
    """HOLDS, IN_PART or FAILS."""
    if whole:
        return HOLDS
    return IN_PART if partly else FAILS
