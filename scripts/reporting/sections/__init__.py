# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's sections: each measures, and writes what it found to the page."""
