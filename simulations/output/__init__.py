"""The results folder: tables, fields, restart files, plots and the report page."""
