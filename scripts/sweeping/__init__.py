# SPDX-License-Identifier: Apache-2.0
"""What scripts/sweep is made of: plan (the sweep file), keys (of results), work (jobs, and what is
finished), bakes (stages and measuring of all runs, and their table), advice (what to set), plots.
"""
