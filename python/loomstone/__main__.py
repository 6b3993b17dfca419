"""python -m loomstone"""

from .cli import main

main()
