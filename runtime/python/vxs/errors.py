"""Errors of the module. SPDX-License-Identifier: MIT"""
from typing import Optional


class VxsError(Exception):
    """A file that cannot be opened, or a bake that failed. result: the number of vxs_result; finding: its number in vxs_findings.h, or None."""

    def __init__(self, text: str, result: int, finding: Optional[int] = None):
        super().__init__(text)
        self.result, self.finding = result, finding


class Cancelled(VxsError):
    """A bake whose progress callback ended it."""
