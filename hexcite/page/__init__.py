"""The guided page: machine, plan, program, data, result and use in a browser, each stage by a command of its own.

`server` answers a browser, `security` says to whom and with what, `jobs` runs commands in processes, `stages` reads the
folders that they write, `machines` the cases, `forms` makes commands of what was filled in, `texts` has the words.
Nothing is kept but those folders.
"""
