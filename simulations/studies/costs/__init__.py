"""Parts of the study of cost: its cases, one measured case, its plots, and GetFEM as peer."""
