"""Compiled functions: machine code of those that Python calls; the others are built into their callers alone.

By itself Numba optimises and translates every function, then again as a part of each of its callers, and of theirs:
the innermost of ten functions ten times. Two thirds of the compiler's work was on code that nobody called.
"""

from __future__ import annotations

import hashlib
import os
from functools import cached_property
from typing import Any

from llvmlite import binding
from numba.core import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher
from numba.extending import overload
from numba.np import arrayobj

from tautflex import compilers


class _PartLibrary(JITCodeLibrary):
    """Code to be linked into that of callers, which optimise it; of its own it has the place of its environment."""

    def finalize(self) -> None:
        code, places = self._final_module, []
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            code.link_in(library._get_module_for_linking(), preserve=True)
        code.verify()
        self._finalize_dynamic_globals()
        for function in code.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.external:
                function.linkage = "linkonce_odr"  # each caller has its copy, and drops it where it is inlined
        for variable in code.global_variables:
            if variable.linkage == binding.Linkage.common:
                places.append(f'@"{variable.name}" = common global ptr null')
        self._shared_module = code
        empty = str(self._codegen._create_empty_module(self.name))
        self._final_module = binding.parse_assembly("\n".join([empty, *places]))
        self._finalize_final_module()


class _PartCompiler(Compiler):
    def define_pipelines(self) -> Any:
        library = _PartLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        library.enable_object_caching()
        self.state.library = library
        return super().define_pipelines()


class _File(IndexDataCacheFile):
    """Each signature's code in a file of its own name: numbers that two processes give at once are the same."""

    def save(self, key: Any, data: Any) -> None:
        types, target, (_, closure) = key
        number = int(hashlib.sha256(f"{types} {target} {closure}".encode()).hexdigest()[:12], 16)
        with compilers.saving():
            name = self._load_index().get(key) or self._data_name(number)
            self._save_data(name, data)
            self._save_index(self._load_index() | {key: name})


class _Cache(FunctionCache):
    _impl_class: Any = CompileResultCacheImpl

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self.function, self.base = function, self._impl.filename_base
        self._cache_file = _File(self._cache_path, self.base, self._impl.locator.get_source_stamp())

    def name(self, types: Any) -> str:
        """What processes call a function of these arguments."""
        return f"{self.base} {types}"

    def size(self, types: Any, context: Any) -> int:
        """Bytes of the code for these arguments in the cache, 0 if there is none."""
        context.refresh()
        name = self._cache_file._load_index().get(self._index_key(types, context.codegen()))
        place = self._cache_file._data_path(name) if name else ""
        return os.path.getsize(place) if os.path.exists(place) else 0

    def load_overload(self, types: Any, context: Any) -> Any:
        code = super().load_overload(types, context)
        module, function = self.function.__module__, self.function.__qualname__
        if code is None and compilers.seek(self.name(types), module, function, tuple(types)):
            code = super().load_overload(types, context)
        return code


class _PartFile(CompileResultCacheImpl):
    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        return f"{super().get_filename_base(fullname, abiflags)}-part"


class _PartCache(_Cache):
    _impl_class = _PartFile


class _Dispatcher(CPUDispatcher):
    _cache: Any
    _cache_class = _Cache

    def enable_caching(self) -> None:
        self._cache = self._cache_class(self.py_func)

    def compile(self, sig: Any) -> Any:
        # Numba's own one puts both shapes into a message; texts are a tenth of all that a first command would compile.
        told, arrayobj.raise_with_shape_context = arrayobj.raise_with_shape_context, _unequal
        try:
            return super().compile(sig)
        finally:
            arrayobj.raise_with_shape_context = told
            if isinstance(self._cache, _Cache):
                compilers.found(self._cache.name(sig))


class _Part(_Dispatcher):
    """What compiled functions call."""

    _cache_class = _PartCache


class Kernel(_Dispatcher):
    """A compiled function, from Python; compiled code sees the part."""

    def compile_if_free(self, types: tuple[Any, ...]) -> bool:
        """Compile for these arguments; False if that has been done, or another process is at it."""
        name = self._cache.name(types)
        if types in self.overloads or not compilers.free(name):
            return False
        try:
            if self._cache.size(types, self.targetctx):
                return False
            self.compile(types)
            return True
        finally:
            compilers.found(name)

    @cached_property
    def part(self) -> _Part:
        """The same function for compiled callers."""
        options = {**self.targetoptions, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        part = _Part(self.py_func, targetoptions=options, pipeline_class=_PartCompiler)
        if isinstance(self._cache, FunctionCache):
            part.enable_caching()
        return part

    @property
    def _numba_type_(self) -> Any:
        return types.Dispatcher(self.part)


def _unequal(found: Any, expected: Any) -> None:
    raise NotImplementedError


@overload(_unequal)
def _compiled_unequal(found: Any, expected: Any) -> Any:
    def refuse(found: Any, expected: Any) -> None:
        raise ValueError("cannot assign slice from input of different size")

    return refuse
