"""Pictures of stored runs at the same instants, side by side in one file.

python tests/benchmarks/strips.py out/async out/implicit --times 1 2 3 --out strip.png
[--width 480 --height 480 --columns 3]
"""
