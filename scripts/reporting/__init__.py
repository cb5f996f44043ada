# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of scripts/report: text, tables, plots and pictures, as Markdown and as one HTML file."""
