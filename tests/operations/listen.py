#!/usr/bin/env python3
"""Several addresses, unix sockets, and sockets that a service manager opened. tests/operations/listen.py"""
import contextlib, os, shutil, signal, socket, stat, subprocess, sys, tempfile
from http.client import HTTPConnection
from support import PROGRAM, check, client_folder, finish, free_port, http, until

# Started instead of the server: makes descriptors 3 and on of those that were passed, as systemd does, and becomes the server.
HANDING_OVER = '''
import os, sys
count = int(sys.argv[1])
given = [os.dup(int(fd)) for fd in sys.argv[2:2 + count]]
high = [os.dup2(fd, 100 + i) for i, fd in enumerate(given)]
for i, fd in enumerate(high):
    os.dup2(fd, 3 + i)
    os.close(fd)
os.environ.update(LISTEN_PID=str(os.getpid()), LISTEN_FDS=str(count), LISTEN_FDNAMES=':'.join('web%d' % i for i in range(count)))
os.execv(sys.argv[2 + count], sys.argv[2 + count:])
'''


class Server:
    """`heliograph serve` with these arguments; `handed`: sockets to be handed over."""

    def __init__(self, folder, *arguments, handed=(), environment=None, toml=None):
        self.err = os.path.join(folder, 'err')
        if toml:
            with open(os.path.join(folder, 'heliograph.toml'), 'w') as f:
                f.write(toml)
        command = [PROGRAM, 'serve', 'cornell', '--client', client_folder(folder), *arguments]
        if handed:
            descriptors = [str(s.fileno()) for s in handed]
            command = [sys.executable, '-c', HANDING_OVER, str(len(handed)), *descriptors, *command]
        with open(self.err, 'w') as err:
            self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=err, stdin=subprocess.DEVNULL, cwd=folder,
                                            env={**os.environ, **(environment or {})}, pass_fds=[s.fileno() for s in handed])
        self.line = self.process.stdout.readline().decode().strip()

    def log(self):
        with open(self.err) as f:
            return f.read()

    def end(self, which=signal.SIGTERM):
        self.process.send_signal(which)
        code = self.process.wait(20)
        self.process.stdout.close()
        return code


def over_unix(path, request='/healthz'):
    """Status and body."""
    connection = HTTPConnection('localhost')
    connection.sock = socket.socket(socket.AF_UNIX)
    with contextlib.closing(connection.sock):
        connection.sock.settimeout(20)
        connection.sock.connect(path)
        connection.request('GET', request)
        answer = connection.getresponse()
        return answer.status, answer.read().decode()


def several(folder):
    path, port = os.path.join(folder, 'a.sock'), free_port()
    server = Server(folder, '--listen', '127.0.0.1:%d' % port, '--listen', 'unix:' + path, '--socket-mode', '0600')
    check('the start line names each', server.line.endswith('on http://127.0.0.1:%d, unix:%s' % (port, path)), server.line)
    check('the port answers', http(port, '/healthz')[0] == 200)
    check('the unix socket answers', over_unix(path) == (200, 'ok\n'))
    check('... with the mode that was asked for', stat.S_IMODE(os.stat(path).st_mode) == 0o600, oct(os.stat(path).st_mode))
    if shutil.which('curl'):
        out = subprocess.run(['curl', '-sS', '--unix-socket', path, 'http://localhost/readyz'], capture_output=True, text=True)
        check('... to curl --unix-socket', out.stdout == '{"ready":true}\n', out.stdout + out.stderr)
        out = subprocess.run(['curl', '-sS', '--unix-socket', path, 'http://localhost/nothing'], capture_output=True, text=True)
        check('... with a 404', out.stdout == 'not found\n', out.stdout + out.stderr)
    second = Server(folder, '--listen', 'unix:' + path)
    check('a second server on it: exit code 2 and why', second.process.wait(20) == 2 and 'somebody listens there' in second.log(),
          second.log().strip().split('\n')[-1])
    check('... and the first one answers on', over_unix(path) == (200, 'ok\n'))
    check('the file goes with the server', server.end() == 0 and not os.path.exists(path))


def stale(folder):
    path = os.path.join(folder, 'b.sock')
    server = Server(folder, '--listen', 'unix:' + path)
    server.end(signal.SIGKILL)
    check('after kill -9 the file stays', os.path.exists(path))
    server = Server(folder, environment={'HELIOGRAPH_LISTEN': 'unix:' + path})
    check('the next server replaces it, by the environment', over_unix(path) == (200, 'ok\n') and server.line.endswith('on unix:' + path),
          server.line)
    server.end()


def by_file(folder):
    path, port = os.path.join(folder, 'c.sock'), free_port()
    server = Server(folder, toml='listen = ["127.0.0.1:%d", "unix:%s"]\n' % (port, path))
    check('a list in heliograph.toml', over_unix(path)[0] == 200 and http(port, '/healthz')[0] == 200, server.line)
    os.remove(os.path.join(folder, 'heliograph.toml'))
    server.end()


def handed_over(folder):
    path, port = os.path.join(folder, 'd.sock'), free_port()
    with contextlib.closing(socket.socket(socket.AF_UNIX)) as local, contextlib.closing(socket.socket()) as tcp:
        local.bind(path)
        tcp.bind(('127.0.0.1', port))
        for one in (local, tcp):
            one.listen(16)
        server = Server(folder, handed=(tcp, local))
        check('sockets that were handed over serve, and no other',
              server.line.endswith('on http://127.0.0.1:%d, unix:%s' % (port, path)), server.line)
        check('... both of them', over_unix(path)[0] == 200 and http(port, '/healthz')[0] == 200)
        check('... their names are in the log', "service manager's socket web1" in server.log())
        check('... a unix socket stays: it is the manager\'s', server.end() == 0 and os.path.exists(path))
        # Whoever connects between two servers waits and is served by the next one.
        with contextlib.closing(socket.create_connection(('127.0.0.1', port), 20)) as waiting:
            waiting.sendall(b'GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n')
            other = free_port()
            server = Server(folder, '--listen', '127.0.0.1:%d' % other, handed=(tcp,))
            check('who connected between two servers is served', waiting.recv(4096).startswith(b'HTTP/1.1 200'))
            check('what --listen names comes beside', http(other, '/healthz')[0] == 200, server.line)
            server.end()
    with contextlib.closing(socket.socket()) as open_to_all:
        open_to_all.bind(('0.0.0.0', free_port()))
        open_to_all.listen(16)
        server = Server(folder, handed=(open_to_all,))
        check('a handed-over port of all machines needs a token, too',
              server.process.wait(20) == 2 and 'can be reached from other machines' in server.log(), server.log().strip())


def doctor(folder):
    path = os.path.join(folder, 'e.sock')
    line = [PROGRAM, 'doctor', 'cornell', '--client', client_folder(folder), '--listen', 'unix:' + path]
    out = subprocess.run(line, capture_output=True, text=True, cwd=folder)
    check('doctor looks at a unix socket', 'unix:%s can be made' % path in out.stdout and out.returncode == 0, out.returncode)
    check('... without making it', not os.path.exists(path))
    out = subprocess.run(line + ['--listen', 'unix:/nowhere/x'], capture_output=True, text=True, cwd=folder)
    check('doctor looks at each', 'can be made' in out.stdout and '/nowhere: No such file' in out.stdout and out.returncode == 1, out.returncode)


if __name__ == '__main__':
    for part in (several, stale, by_file, handed_over, doctor):
        with tempfile.TemporaryDirectory(prefix='heliograph-listen-') as place:
            part(place)
    finish()
