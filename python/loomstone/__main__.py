"""python -m loomstone"""

from .cli.application import main

main()
