"""Checks that README.md has the tables that print_parameters prints."""
import subprocess
import sys

BEGIN = '<!-- parameters -->\n'
END = '<!-- end of parameters -->'


def main():
    """Returns the exit status. Arguments: the program and README.md."""
    program, readme = sys.argv[1:]
    printed = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    with open(readme, encoding='utf-8') as file:
        text = file.read()
    written = text[text.index(BEGIN) + len(BEGIN):text.index(END)]
    if written != printed:
        print('README.md differs from what print_parameters prints')
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
