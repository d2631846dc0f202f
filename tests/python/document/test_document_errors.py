"""What is raised for documents."""

import stark
from stark.document import DocumentError


def test_it_is_an_error_of_stark_and_a_value_error() -> None:
    assert stark.DocumentError is DocumentError
    assert issubclass(DocumentError, stark.InvalidArgument) and issubclass(DocumentError, stark.Error)
