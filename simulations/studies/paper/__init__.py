"""The figures and sentences of Heß, Giesa, Riechert, Wilhayn, Appl. Sci. 2026, 16(1), 473, made again and checked."""
